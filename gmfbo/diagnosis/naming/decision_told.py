"""From a decision to the values of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.fitting.intervals import Spread
from gmfbo.diagnosis.naming.decision import Decision, Round
from gmfbo.diagnosis.result.augmentation import Augmentation
from gmfbo.diagnosis.result.certainty import statement_of
from gmfbo.diagnosis.result.explained import Share
from gmfbo.diagnosis.result.named_effect import (
    IdentifiedValue,
    NamedEffect,
    NotTestable,
)
from gmfbo.physics import CATALOGUE, Units
from gmfbo.plain_words import quantity
from gmfbo.sources.binding.augmented_binding import PORT_OUTPUTS
from gmfbo.sources.twin.twin import FmuTwin

if TYPE_CHECKING:
    from gmfbo.sources.export.export import PhysicsParameter


def units_of(case: Case) -> Units:
    """Units of the twin's ports and states, as its FMU spells them."""
    file, variables = case.twin.file, case.twin.binding.variables

    def unit(name: str | None, otherwise: str) -> str:
        return (variables[name].variable.unit or otherwise) if name else otherwise

    states = file.states
    position = unit(states.get("position"), "rad")
    torque = unit(file.ports.get("torque"), "N.m" if position == "rad" else "N")
    command = unit(states.get("command"), unit(file.ports.get("command"), torque))
    current = unit(states.get("current"), command)
    return Units(
        torque=torque,
        position=position,
        velocity=unit(states.get("velocity"), f"{position}/s"),
        command=command,
        current=current,
        load=torque if "load_torque" in states else current,
    )


def named_effects(
    decision: Decision,
    augmented: Fitted,
    spread: Spread,
    units: Units,
    shares: Mapping[str, Share | None],
    twin: FmuTwin,
) -> tuple[NamedEffect, ...]:
    """Accepted effects at the values that the held-out recordings were scored with.

    Parameters
    ----------
    decision : Decision
        What was accepted.
    augmented : Fitted
        Fit to the recordings that were not held out.
    spread : Spread
        Of that fit.
    units : Units
        Of the twin.
    shares : mapping of str to Share or None
        What each effect explains.
    twin : FmuTwin
        Whose parameters may explain as much.
    """
    identified = _identified(augmented, spread, units)
    at = {c.effect: {**c.more, **c.values} for c in augmented.hypothesis.effects}
    named = []
    for found in decision.rounds:
        name, law = found.winner.name, CATALOGUE[found.winner.name]
        fact = law.statement(at[name], units, units.place)
        named.append(
            NamedEffect(
                name=name,
                port=law.port,
                probability=found.shares[0].probability if found.shares else found.probability,
                statement=statement_of(fact, found.names, found.probability, _instead(found, twin)),
                equation=law.equation,
                parameters=identified[name],
                evidence=found.gain,
                threshold=decision.threshold,
                evidence_per_recording=found.per_recording,
                indistinguishable_from=found.names[1:],
                rivals=found.shares,
                share=shares.get(name),
                belief=found.belief,
            )
        )
    return tuple(named)


def _identified(
    augmented: Fitted, spread: Spread, units: Units
) -> dict[str, dict[str, IdentifiedValue]]:
    """Values of each effect's parameters."""
    place = len(augmented.hypothesis.setting.uncertain)
    identified: dict[str, dict[str, IdentifiedValue]] = {}
    for candidate in augmented.hypothesis.effects:
        own = identified.setdefault(candidate.effect, {})
        for i, parameter in enumerate(candidate.parameters, start=place):
            if parameter not in candidate.law.own_nuisances:
                own[parameter.name] = IdentifiedValue(
                    float(augmented.x[i]),
                    units.resolve(parameter.unit),
                    float(spread.low[i]),
                    float(spread.high[i]),
                )
        place += len(candidate.parameters)
    return identified


def _instead(found: Round, twin: FmuTwin) -> dict[str, str]:
    """What each parameter of the twin in a set would be, in words."""
    told = {}
    for rival in found.rivals:
        kind, _, name = rival.name.partition(":")
        if kind == "parameter":
            unit, value = twin.binding.variables[name].variable.unit, rival.fitted.parameters[name]
            nominal = quantity(twin.nominal(name), unit)
            told[rival.name] = f"{quantity(value, unit)} instead of {nominal}"
    return told


def not_testable(reasons: Mapping[str, str], decision: Decision) -> tuple[NotTestable, ...]:
    """Effects on which nothing can be said, in the catalogue's order."""
    entries = []
    named = {name for entry in decision.rounds for name in entry.names}
    for name in CATALOGUE:
        if name in named:
            continue
        if name in reasons:
            entries.append(NotTestable(name, reasons[name]))
        elif name in decision.untestable:
            entries.append(NotTestable(name, decision.untestable[name]))
    return tuple(entries)


def augmentation_of(case: Case, augmented: Fitted, units: Units) -> Augmentation:
    """Everything that the exported twin is made of.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    augmented : Fitted
        Whose values become the defaults.
    units : Units
        Of the twin.
    """

    point = augmented.hypothesis.point(augmented.x)
    fixed = case.simulations.settings
    exposed: list[PhysicsParameter] = []
    for candidate in augmented.hypothesis.effects:
        exposed += _exposed(candidate, point.physics, units)
    shown = {parameter.name for parameter in exposed}
    settings = {
        **{k: v for k, v in fixed.items() if case.twin.file.ports},
        **{name: value for name, value in point.physics.items() if name not in shown},
    }
    simulations = case.simulations
    return Augmentation(
        case.twin,
        point.parameters,
        tuple(exposed),
        settings,
        case.substeps,
        from_rest=augmented.hypothesis.acts_at_rest
        and simulations.begins_at_rest
        and simulations.rest > 0,
    )


def _exposed(
    candidate: Candidate, physics: Mapping[str, float], units: Units
) -> list[PhysicsParameter]:
    from gmfbo.sources.export.export import PhysicsParameter

    law = candidate.law
    return [
        PhysicsParameter(
            f"{law.name}.{parameter.name}",
            physics[f"{law.name}.{parameter.name}"],
            units.resolve(parameter.unit),
            f"{parameter.words}: {law.equation}",
        )
        for parameter in candidate.parameters
        if law.port in PORT_OUTPUTS and parameter not in law.own_nuisances
    ]
