"""Which cases a benchmark has: kinds, machines and effects, before any number is drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from tests.blind.hidden import EFFECTS, Hidden
from tests.blind.machines import MACHINES
from tests.blind.outside import LAWS_OUTSIDE, OUTSIDE
from tests.blind.sizing import BANDS

Item = TypeVar("Item")

SHARES = {"null": 50, "stressed_null": 60, "decoy": 40, "single": 260, "pair": 60, "outside": 40}
"""Cases of each kind among 510; 150 of them have nothing to name."""

OUT_OF_REACH_SHARE = 65
"""Of so many single effects one is put where the twin lacks the port for it."""

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
    ("stribeck_friction", "sensor_lag"),
    ("asymmetric_friction", "torque_ripple"),
    ("torsional_compliance", "coulomb_friction"),
    ("presliding_friction", "periodic_disturbance"),
    ("constant_torque_offset", "transport_delay"),
    ("actuator_dead_zone", "cogging_torque"),
    ("pulse_disturbance", "stribeck_friction"),
    ("sensor_eccentricity", "coulomb_friction"),
    ("supply_voltage_limit", "gravity_torque"),
    ("hysteresis", "cogging_torque"),
    ("quadratic_drag", "torsional_compliance"),
    ("actuator_rate_limit", "elastic_return"),
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
    "friction_without_reversal",
    "more_viscous",
    "stiff_shaft",
    "cold_motor",
    "gap_below_resolution",
    "supply_out_of_reach",
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
_MEASURED = {
    "torque": ("servo_measured", "axis_measured", "wires_measured", "bench_measured"),
    "command": ("servo_measured", "axis_measured", "wires_measured", "bench_measured"),
    "sensor": ("servo_measured", "axis_measured", "wires_measured"),
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
        Stresses of a stressed null, the name of a decoy, `exact` for a null with the right
        parameters.
    band : str
        Of `BANDS`, for single effects.
    """

    kind: str
    machine: str
    effects: tuple[str, ...] = ()
    details: tuple[str, ...] = ()
    band: str = "above"

    @property
    def is_within_reach(self) -> bool:
        """Whether the twin has the ports that the hidden effects need."""
        ports = MACHINES[self.machine].ports
        return all({**EFFECTS, **LAWS_OUTSIDE}[name].port in ports for name in self.effects)


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
        *nulls_of(counts["null"], counts["stressed_null"], rng),
        *singles_of(counts["single"], rng),
        *pairs_of(counts["pair"], rng),
        *outside_of(counts["outside"], rng),
        *decoys_of(counts["decoy"], rng),
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


def nulls_of(clean: int, stressed: int, rng: np.random.Generator) -> list[Plan]:
    """Every third clean null has the right parameters; those of the others are wrong."""
    machines = _shuffled(list(MACHINES), rng)
    stresses = _shuffled(STRESSES, rng)
    plans = [
        Plan("null", machines[i % len(machines)], details=("exact",) if i % 3 == 0 else ())
        for i in range(clean)
    ]
    for i in range(stressed):
        machine = machines[(clean + i + i // len(machines)) % len(machines)]
        stress = stresses[i % len(stresses)]
        if MACHINES[machine].is_open_loop:  # such a twin compares no column of a command
            stress = tuple(name for name in stress if name not in _COLUMN_STRESSES)
        plans.append(Plan("stressed_null", machine, details=stress or ("coloured_noise",)))
    return plans


_COLUMN_STRESSES = frozenset({"column_scale", "logger_new"})


def singles_of(count: int, rng: np.random.Generator) -> list[Plan]:
    """Each effect as often as every other, a third of its cases in each band of gains."""
    out_of_reach = count // OUT_OF_REACH_SHARE
    plans = [
        Plan("single", machine, (effect,))
        for machine, effect in [_OUT_OF_REACH[i % len(_OUT_OF_REACH)] for i in range(out_of_reach)]
    ]
    own, bands = list(EFFECTS), list(BANDS)
    first = {name: int(turn) for name, turn in zip(own, rng.permutation(len(own)), strict=True)}
    rows = {**_BY_PORT, **{f"{port} measured": row for port, row in _MEASURED.items()}}
    turn = {port: int(rng.integers(len(row))) for port, row in rows.items()}
    names: list[str] = []
    while len(names) < count - out_of_reach:
        names += _shuffled(own, rng)
    for index, name in enumerate(names[: count - out_of_reach]):
        effect = EFFECTS[name]
        port = f"{effect.port} measured" if effect.measured_only else effect.port
        machine = ""
        while not machine or (effect.rotary_only and not MACHINES[machine].is_rotary):
            machine = rows[port][turn[port] % len(rows[port])]
            turn[port] += 1
        band = bands[(first[name] + index // len(own)) % len(bands)]
        plans.append(Plan("single", machine, (name,), band=band))
    return plans


def pairs_of(count: int, rng: np.random.Generator) -> list[Plan]:
    """Each pair as often as every other, on machines with all ports."""
    pairs = _shuffled(PAIRS, rng)
    machines = ("servo", "wires_pid", "servo", "wires_pd_filtered", "wires_cascade_p_pi")
    return [
        Plan("pair", machines[(i + i // len(PAIRS)) % len(machines)], pairs[i % len(pairs)])
        for i in range(count)
    ]


def outside_of(
    count: int, rng: np.random.Generator, laws: Mapping[str, Hidden] = OUTSIDE
) -> list[Plan]:
    """Each of the laws outside the catalogue as often as every other."""
    names = _shuffled(list(laws), rng)
    plans = []
    for i in range(count):
        law = laws[name := names[i % len(names)]]
        machines = [
            machine
            for machine in ("servo", "axis", "wires_pid", "servo_torque", "wires_pd_filtered")
            if law.port in MACHINES[machine].ports
            and not (law.rotary_only and not MACHINES[machine].is_rotary)
        ]
        plans.append(Plan("outside", machines[(i + i // len(names)) % len(machines)], (name,)))
    return plans


def decoys_of(count: int, rng: np.random.Generator) -> list[Plan]:
    """Each decoy as often as every other."""
    machines, names = ("servo", "axis"), _shuffled(DECOYS, rng)
    return [
        Plan(
            "decoy",
            machines[(i + i // len(names)) % len(machines)],
            details=(names[i % len(names)],),
        )
        for i in range(count)
    ]


def _shuffled(items: Sequence[Item], rng: np.random.Generator) -> list[Item]:
    return [items[index] for index in rng.permutation(len(items))]
