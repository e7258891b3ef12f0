"""Which effects this twin and these recordings can test, and why not the others."""

from __future__ import annotations

from collections.abc import Collection

from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.physics import CATALOGUE, Effect, Excitation
from gmfbo.physics.needs import needed_states
from gmfbo.sources.twin_file.twin_file import TwinFile

NOT_EXCITED_BY_REVERSALS = "not excited: no reversal of the velocity"
"""Reason for effects that only a reversal makes sure: one way they may look like another."""

ONE_WAY_FRICTION = "constant_torque_offset"
"""Effect that friction is while an axis moves one way."""

_GAINS = {"actuator_gain_loss", "sensor_scale"}


def untestable(
    file: TwinFile,
    excitation: Excitation,
    *,
    assume: Collection[str] = (),
    exclude: Collection[str] = (),
    has_inertia: bool,
    is_open: bool,
) -> dict[str, str]:
    """Reasons by effect why it cannot be tested.

    Parameters
    ----------
    file : TwinFile
        Ports and states of the twin.
    excitation : Excitation
        What the recordings show.
    assume, exclude : collection of str
        Effects that the user takes for granted, or rules out.
    has_inertia : bool
        The twin names a parameter from which a load inertia can be taken.
    is_open : bool
        No controller is in the twin: a gain and an inertia are one.
    """
    reasons = {}
    for name, effect in CATALOGUE.items():
        reason = _why_not(effect, file, excitation, has_inertia)
        if is_open and name in _GAINS and (inertia := file.roles.get("inertia")) in file.uncertain:
            reason = f"is parameter {inertia}"
        if name in exclude:
            reason = "excluded by the user"
        if reason is not None and name not in assume:
            reasons[name] = reason
    return reasons


def _why_not(
    effect: Effect, file: TwinFile, excitation: Excitation, has_inertia: bool
) -> str | None:
    if effect.port not in file.ports:
        return f"the twin has no {effect.port} port"
    for needed in needed_states(effect):
        if not set(needed.any_of) & set(file.states):
            return needed.lacking
    if effect.inertia_share and not has_inertia:
        return "the twin names no inertia in [roles] from which the load's could be taken"
    if (inertia := file.roles.get("inertia")) in file.uncertain and (
        "inertia" in effect.parameter_like and not effect.inertia_share
    ):
        return f"is parameter {inertia}"
    silent = effect.not_excited(excitation)
    return None if silent is None else f"not excited: {silent}"


def candidates(testable: Collection[str], excitation: Excitation) -> list[Candidate]:
    """Every start of every effect that can be tested."""
    return [
        Candidate(name, dict(values))
        for name in CATALOGUE
        if name in testable
        for values in CATALOGUE[name].starts(excitation)
    ]
