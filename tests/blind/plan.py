"""Which cases a benchmark has: kinds, machines and effects, before any number is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from tests.blind.hidden import EFFECTS, OUTSIDE
from tests.blind.machines import MACHINES

Item = TypeVar("Item")

SHARES = {"null": 20, "stressed_null": 20, "single": 60, "pair": 8, "outside": 8, "decoy": 4}
"""Cases of each kind among 120."""

STRESSES = (
    ("torque_lag",),
    ("column_scale",),
    ("logger_new",),
    ("clock_skew",),
    ("coloured_noise",),
    ("drive_gain",),
    ("logger_new", "column_scale"),
    ("coloured_noise", "drive_gain"),
    ("torque_lag", "clock_skew"),
)
PAIRS = (
    ("coulomb_friction", "cogging_torque"),
    ("gravity_torque", "coulomb_friction"),
    ("actuator_saturation", "coulomb_friction"),
    ("transport_delay", "coulomb_friction"),
    ("cogging_torque", "quadratic_drag"),
    ("coulomb_friction", "elastic_return"),
    ("backlash", "cogging_torque"),
    ("gravity_torque", "actuator_lag"),
)
DECOYS = (
    "drive_gain",
    "shared_limit",
    "limit_out_of_reach",
    "sensor_zero",
    "more_inertia",
    "shared_lag",
    "sensor_scale",
    "rate_out_of_reach",
)
_BY_PORT = {
    "torque": (
        "servo",
        "wires_pid",
        "axis",
        "servo_torque",
        "bench",
        "servo",
        "wires_cascade_p_pi",
        "axis",
        "wires_pd_filtered",
    ),
    "command": (
        "servo",
        "wires_cascade_p_pi",
        "axis",
        "wires_pid",
        "bench",
        "servo",
        "wires_pd_filtered",
    ),
    "sensor": ("servo", "wires_pid", "axis", "servo", "wires_cascade_p_pi"),
}
_OUT_OF_REACH = (
    ("servo_none", "coulomb_friction"),
    ("servo_torque", "actuator_saturation"),
    ("servo_none", "transport_delay"),
    ("servo_torque", "sensor_lag"),
    ("servo_none", "cogging_torque"),
    ("servo_torque", "transport_delay"),
)


@dataclass(frozen=True)
class Plan:
    """One case to be made.

    Attributes
    ----------
    kind : str
        One of `SHARES`.
    machine : str
        Of `MACHINES`.
    effects : tuple of str
        Hidden ones; of `OUTSIDE` for that kind.
    details : tuple of str
        Stresses of a stressed null, or the name of a decoy.
    """

    kind: str
    machine: str
    effects: tuple[str, ...] = ()
    details: tuple[str, ...] = ()

    @property
    def is_within_reach(self) -> bool:
        """Whether the twin has the ports that the hidden effects need."""
        ports = MACHINES[self.machine].ports
        return all({**EFFECTS, **OUTSIDE}[name].port in ports for name in self.effects)


def make_plan(cases: int, seed: int) -> list[Plan]:
    """Plans of a benchmark in random order; the same for the same numbers.

    Parameters
    ----------
    cases : int
        How many; `SHARES` are kept as far as whole numbers allow.
    seed : int
        Decides on order, machines and effects.
    """
    rng = np.random.default_rng([seed, 0])
    counts = _counts(cases)
    plans = [
        *_nulls(counts["null"], counts["stressed_null"], rng),
        *_singles(counts["single"], rng),
        *_pairs(counts["pair"], rng),
        *_outside(counts["outside"], rng),
        *_decoys(counts["decoy"], rng),
    ]
    return [plans[index] for index in rng.permutation(len(plans))]


def _counts(cases: int) -> dict[str, int]:
    """Whole numbers by largest remainder; ties go to the earlier kind."""
    total = sum(SHARES.values())
    exact = {kind: cases * share / total for kind, share in SHARES.items()}
    counts = {kind: int(value) for kind, value in exact.items()}
    order = sorted(exact, key=lambda kind: counts[kind] - exact[kind])
    for kind in order[: cases - sum(counts.values())]:
        counts[kind] += 1
    return counts


def _nulls(clean: int, stressed: int, rng: np.random.Generator) -> list[Plan]:
    machines = _shuffled(list(MACHINES), rng)
    stresses = _shuffled(STRESSES, rng)
    plans = [Plan("null", machines[i % len(machines)]) for i in range(clean)]
    for i in range(stressed):
        machine = machines[(clean + i) % len(machines)]
        stress = stresses[i % len(stresses)]
        if machine == "bench":  # an open-loop twin compares no column of a command
            kept = tuple(name for name in stress if name not in _COLUMN_STRESSES)
            stress = kept or ("coloured_noise",)
        plans.append(Plan("stressed_null", machine, details=stress))
    return plans


_COLUMN_STRESSES = frozenset({"column_scale", "logger_new"})


def _singles(count: int, rng: np.random.Generator) -> list[Plan]:
    out_of_reach = count // 20
    plans = [
        Plan("single", machine, (effect,))
        for machine, effect in [_OUT_OF_REACH[i % len(_OUT_OF_REACH)] for i in range(out_of_reach)]
    ]
    names: list[str] = []
    while len(names) < count - out_of_reach:
        names += _shuffled(list(EFFECTS), rng)
    turn = {port: int(rng.integers(len(row))) for port, row in _BY_PORT.items()}
    for name in names[: count - out_of_reach]:
        effect = EFFECTS[name]
        machine = ""
        while not machine or (effect.rotary_only and not MACHINES[machine].is_rotary):
            row = _BY_PORT[effect.port]
            machine = row[turn[effect.port] % len(row)]
            turn[effect.port] += 1
        plans.append(Plan("single", machine, (name,)))
    return plans


def _pairs(count: int, rng: np.random.Generator) -> list[Plan]:
    pairs, machines = _shuffled(PAIRS, rng), ("servo", "wires_pid", "servo", "wires_pd_filtered")
    return [Plan("pair", machines[i % len(machines)], pairs[i % len(pairs)]) for i in range(count)]


def _outside(count: int, rng: np.random.Generator) -> list[Plan]:
    names, machines = _shuffled(list(OUTSIDE), rng), ("servo", "axis", "servo_torque", "wires_pid")
    return [
        Plan("outside", machines[(i + i // 4) % len(machines)], (names[i % len(names)],))
        for i in range(count)
    ]


def _decoys(count: int, rng: np.random.Generator) -> list[Plan]:
    machines = ("servo", "axis")
    return [
        Plan("decoy", machines[i % len(machines)], details=(DECOYS[i % len(DECOYS)],))
        for i in range(count)
    ]


def _shuffled(items: Sequence[Item], rng: np.random.Generator) -> list[Item]:
    return [items[index] for index in rng.permutation(len(items))]
