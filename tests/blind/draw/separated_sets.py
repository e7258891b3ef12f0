"""Whether an oracle tells the true law from the other members of a set.

A law is owed where the oracle (`tests/blind/oracle.py`) gains more than `OWED` by it over
parameters alone. By the same measure a law is separated from another one: the gain of the true
plant over a plant that has the other law in its place, whose free values are refitted with the
twin's parameters and with what else is hidden.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from tests.blind.draw.equivalents import same_statement
from tests.blind.draw.judging import Judged
from tests.blind.draw.law_coordinates import FREE, Coordinates
from tests.blind.draw.remade import Remade
from tests.blind.gains import OWED
from tests.blind.hidden import Changes
from tests.blind.oracle import Oracle
from tests.blind.truth import Diverged, Vector


@dataclass(frozen=True)
class Statement:
    """A claim that holds what is hidden, and the laws it could be mistaken for.

    Attributes
    ----------
    law : str
        The true one.
    told : frozenset of str
        Other members of its set that are no equivalents of the true law.
    rivals : frozenset of str
        These, or, where none is in the set, all that stood in a set with this law in any case.
    """

    law: str
    told: frozenset[str]
    rivals: frozenset[str]


def partners_of(judged: Iterable[Judged]) -> dict[str, frozenset[str]]:
    """Laws that stood in one set in any case of a draw, by law; equivalents count as one."""
    partners: dict[str, frozenset[str]] = {}
    for claim in (claim for one in judged for claim in one.claims):
        members = _laws(claim.members)
        for name in members:
            partners[name] = partners.get(name, frozenset()) | members - {name}
    return partners


def statements_of(judged: Judged, partners: Mapping[str, frozenset[str]]) -> list[Statement]:
    """Claims of a case that hold a hidden law by its own name, not by its family's.

    Parameters
    ----------
    judged : Judged
        The case.
    partners : mapping of str to frozenset of str
        Of `partners_of`.
    """
    found = []
    for claim in judged.claims:
        members = _laws(claim.members)
        for law in members & set(judged.hidden):
            told = members - {law}
            found.append(Statement(law, told, told or partners.get(law, frozenset())))
    return found


def _laws(members: frozenset[str]) -> frozenset[str]:
    return frozenset(same_statement(name) for name in members)


@dataclass(frozen=True)
class Separation:
    """What a case hides, against plants that hold other laws in its place.

    Attributes
    ----------
    case : Remade
        What was drawn.
    answer : mapping
        Of the case.
    """

    case: Remade
    answer: Mapping[str, Any]

    def gain(self, law: str, rival: str) -> float:
        """Gain of the truth over the best plant with another law in the place of one.

        Parameters
        ----------
        law : str
            A hidden one.
        rival : str
            That replaces it.

        Returns
        -------
        float
            Expected drop of chi2; the smallest that was found from several starts, and no more
            than over a plant without the law.
        """
        others: Changes = {}
        groups: list[tuple[str, ...]] = [(name,) for name in self.case.machine.free]
        for effect in self.answer["effects"]:
            if effect["name"] != law:
                others.update(effect["changes"])
                groups += FREE[effect["name"]]
        own = next(effect for effect in self.answer["effects"] if effect["name"] == law)
        gain = float(own["added_gain"])  # over nothing in its place, as small as it may be
        for start in starts(self.case, own, rival):
            plant = {**self.case.values, **others, **start}
            free = [group for group in (*groups, *FREE[rival]) if all(plant.get(n) for n in group)]
            # Gains of the controller are those of each recording: only what moves is handed on.
            moving = {**others, **start} | {n: plant[n] for group in free for n in group}
            gain = min(gain, self._over(Coordinates(moving, list(dict.fromkeys(free)))))
            if gain < OWED:
                break
        return gain

    def _over(self, rival: Coordinates) -> float:
        """Over a plant about some values: fitted without noise, judged with it."""
        oracle, count = self.case.oracle, len(rival.groups)
        try:
            least, x = self._quiet.gain_over(self._quiet_means, rival.at, count)
            gain = float(np.sum(oracle.difference(self._means, rival.at(x)) ** 2))
            if least < OWED < gain:  # noise decides: it is fitted with it too
                nearer = Coordinates(rival.at(x), rival.groups)
                gain = min(gain, oracle.gain_over(self._means, nearer.at, count)[0])
        except Diverged:
            return float("inf")
        return gain

    @cached_property
    def _means(self) -> list[Vector]:
        return self.case.oracle.means(self.case.changes)

    @cached_property
    def _quiet(self) -> _Quiet:
        oracle = self.case.oracle
        return _Quiet(**{one.name: getattr(oracle, one.name) for one in fields(oracle)})

    @cached_property
    def _quiet_means(self) -> list[Vector]:
        return self._quiet.means(self.case.changes)


class _Quiet(Oracle):
    """The same oracle on runs without noise: eight times as fast."""

    def means(self, changes: Mapping[str, float]) -> list[Vector]:
        return [np.column_stack([run.reading, run.held]) for run in self.runs(changes)]


def starts(case: Remade, effect: Mapping[str, Any], rival: str) -> list[Changes]:
    """Where a fit of another law begins: near what it would have to look like.

    Parameters
    ----------
    case : Remade
        What was drawn.
    effect : mapping
        Of the answer: the true law.
    rival : str
        The other law.

    Raises
    ------
    KeyError
        For two laws of which nobody has said how one begins where the other is true.
    """
    law, c = effect["name"], effect["changes"]
    if law in ("coulomb_friction", "asymmetric_friction", "presliding_friction", "hysteresis"):
        return _frictions(case, law, c, rival)
    if (law, rival) == ("supply_voltage_limit", "pulse_disturbance"):
        return _pulses(case, effect)
    if (law, rival) == ("pulse_disturbance", "supply_voltage_limit"):
        return _supplies(case)
    return {
        ("actuator_lag", "sensor_lag"): lambda: [{"sensor_time": c["drive_lag"]}],
        ("sensor_lag", "actuator_lag"): lambda: [{"drive_lag": c["sensor_time"]}],
        ("actuator_gain_loss", "sensor_scale"): lambda: [{"sensor_scale": c["drive_gain_error"]}],
        ("sensor_scale", "actuator_gain_loss"): lambda: [{"drive_gain_error": c["sensor_scale"]}],
    }[law, rival]()


def _frictions(case: Remade, law: str, c: Changes, rival: str) -> list[Changes]:
    """Of the same level; springs as long as the true one, or as a machine of this kind has them."""
    level = (
        c.get("bristle_level")
        or c.get("slip_force")
        or 0.5 * (c["friction_positive"] + c["friction_negative"])
    )
    length = 0.1 * case.machine.deflection
    if law == "presliding_friction":
        length = c["bristle_level"] / c["bristle_stiffness"]
    elif law == "hysteresis":
        length = 0.3 * c["slip_length"]
    speed = max(float(np.max(np.abs(run.velocity))) for run in case.oracle.clean)
    if rival in ("coulomb_friction", "asymmetric_friction"):
        return [{"friction_positive": level, "friction_negative": level}]
    if rival == "presliding_friction":
        damping = 0.3 * level / speed
        return [
            {
                "bristle_level": level,
                "bristle_stiffness": level / length,
                "bristle_damping": damping,
            }
        ]
    if rival == "hysteresis":
        return [{"slip_force": level, "slip_length": 3.0 * length}]
    raise KeyError((law, rival))


def _pulses(case: Remade, effect: Mapping[str, Any]) -> list[Changes]:
    """In the longest windows where the supply limits, as large as explains most there."""
    windows = sorted(effect["windows"], key=lambda w: w[1] - w[2])[:3]
    oracle, found = case.oracle, []
    rest = {k: v for k, v in case.changes.items() if k not in effect["changes"]}
    true = oracle.means(case.changes)
    before = oracle.difference(true, rest)
    for _, start, end in windows:
        size = 0.01 * case.values["torque_gain"] * effect["changes"]["supply_limit"]
        pulse = {"pulse": size, "pulse_start": start, "pulse_duration": end - start}
        moved = oracle.difference(true, {**rest, **pulse}) - before
        pulse["pulse"] *= float(-(moved @ before) / (moved @ moved))
        found.append(pulse)
    return found


def _supplies(case: Remade) -> list[Changes]:
    """Where the recordings' worst points, by voltage and by their back-EMF, just meet it."""
    runs = case.oracle.clean
    command = max(float(np.max(np.abs(run.new))) for run in runs)
    speed = max(float(np.max(np.abs(run.velocity))) for run in runs)
    mixed = max(float(np.max(np.abs(run.new / command + run.velocity / speed))) for run in runs)
    return [
        {"supply_limit": share * mixed * command, "supply_slope": command / speed}
        for share in (0.95, 0.8)
    ]


def smallest(gains: Mapping[str, float | None]) -> float | None:
    """Gain over the nearest rival; None where there is none, infinite where none can be run.

    Parameters
    ----------
    gains : mapping of str to float or None
        By rival; None where it cannot be run.
    """
    return min((np.inf if g is None else g for g in gains.values()), default=None)


def separated(statement: Mapping[str, Any]) -> bool:
    """Whether an oracle tells a law from all its rivals.

    Parameters
    ----------
    statement : mapping
        `gains`: by rival.
    """
    gain = smallest(statement["gains"])
    return gain is not None and gain > OWED
