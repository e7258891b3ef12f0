"""A case in the making: what the plant is, what the user believes, what the logger does wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from tests.blind.hidden import Changes, Rng, Setting
from tests.blind.machines import Machine, variation
from tests.blind.plan import Plan
from tests.blind.recording import Logger


@dataclass
class Draft:
    """What is decided so far.

    Attributes
    ----------
    true, believed : dict of str to float
        The plant without effects, and what the twin holds.
    logger : Logger
        What writes the recordings.
    logged : str
        What the twin file says of it; empty where it says nothing.
    uncertain_scale : float
        Of the command's column, as the twin file declares it.
    decoy : dict of str to float
        An effect that leaves nothing to name.
    notes : dict
        For the answer.
    """

    true: dict[str, float]
    believed: dict[str, float]
    logger: Logger
    logged: str = ""
    uncertain_scale: float = 0.0
    decoy: Changes = field(default_factory=dict)
    notes: dict[str, Any] = field(default_factory=dict)


def draft_of(plan: Plan, machine: Machine, rng: Rng) -> Draft:
    """True and believed parameters, a logger, and the stresses of the plan."""
    believed = variation(machine, rng)
    true = dict(believed)
    errors = {"inertia": rng.uniform(0.05, 0.15), "viscous": rng.uniform(0.05, 0.3)}
    ways = rng.choice([-1.0, 1.0], 2)
    if not machine.is_measured and "exact" not in plan.details:
        for way, (name, error) in zip(ways, errors.items(), strict=True):
            true[name] *= 1.0 + way * error
    convention = "new" if rng.random() < 0.3 or machine.is_open_loop else "held"
    draft = Draft(true, believed, Logger(convention))
    if rng.random() < 0.4 and not machine.is_open_loop:
        draft.logged = convention
    if rng.random() < 0.3 and not machine.is_open_loop:
        draft.uncertain_scale = 0.05
    draft.notes["stress"] = list(plan.details)
    for stress in plan.details if plan.kind == "stressed_null" else ():
        _STRESSES[stress](draft, rng)
    return draft


def _stress_lag(draft: Draft, rng: Rng) -> None:
    lag = draft.true.get("torque_lag", 0.0)
    draft.true["torque_lag"] = lag * rng.uniform(0.8, 1.3) if lag else rng.uniform(5e-5, 1.5e-4)


def _stress_scale(draft: Draft, rng: Rng) -> None:
    draft.logger = draft.logger.changed(scale=1.0 + rng.choice([-0.03, 0.03]))
    draft.uncertain_scale = 0.05 if rng.random() < 0.5 else 0.0


def _stress_convention(draft: Draft, rng: Rng) -> None:
    draft.logger, draft.logged = draft.logger.changed(convention="new"), ""


def _stress_clock(draft: Draft, rng: Rng) -> None:
    draft.logger = draft.logger.changed(skew=rng.uniform(100e-6, 200e-6) * rng.choice([-1.0, 1.0]))


def _stress_colour(draft: Draft, rng: Rng) -> None:
    draft.logger = draft.logger.changed(colour=0.95)


def _stress_gain(draft: Draft, rng: Rng) -> None:
    draft.true["drive_gain_error"] = rng.uniform(0.01, 0.02) * rng.choice([-1.0, 1.0])


_STRESSES: Mapping[str, Callable[[Draft, Rng], None]] = {
    "torque_lag": _stress_lag,
    "column_scale": _stress_scale,
    "logger_new": _stress_convention,
    "clock_skew": _stress_clock,
    "coloured_noise": _stress_colour,
    "drive_gain": _stress_gain,
}


def apply_decoy(name: str, setting: Setting, draft: Draft, rng: Rng) -> None:
    """Put in something that is there but leaves nothing to name."""
    true, believed, decoy = draft.true, draft.believed, draft.decoy
    if name == "shared_limit":
        true["u_limit"] = believed["u_limit"] = float(f"{0.6 * setting.peak_command:.4g}")
    elif name == "shared_lag":
        lag = 2e-3 if "torque_lag" in setting.machine.fixed else 0.0
        true["torque_lag"] = believed["torque_lag"] = lag
    elif name == "more_inertia":
        decoy["load_inertia_extra"] = rng.uniform(0.15, 0.3) * believed["inertia"]
    elif name == "more_viscous":
        true["viscous"] = believed["viscous"] * rng.uniform(1.4, 1.9)
    elif name == "stiff_shaft":
        share = rng.uniform(0.2, 0.4)
        load, stiff = share * true["inertia"], (6.28 * 1500.0) ** 2 * share * true["inertia"]
        decoy.update(load_inertia=load, inertia=(1.0 - share) * true["inertia"])
        decoy.update(shaft_stiffness=stiff, shaft_damping=0.1 * (stiff * load) ** 0.5)
    elif name == "cold_motor":
        decoy.update(heat_loss=0.3, heat_time=3e3, heat_scale=setting.rms_command)
    elif name == "gap_below_resolution":
        decoy["play"] = 0.3 * setting.machine.quantum
    elif name == "friction_without_reversal":
        level = rng.uniform(0.03, 0.1) * setting.torque
        decoy.update(friction_positive=level, friction_negative=level)
    else:
        decoy.update(_ONE_VALUE[name](setting, rng))


_ONE_VALUE: Mapping[str, Callable[[Setting, Rng], Changes]] = {
    "drive_gain": lambda s, rng: {"drive_gain_error": -rng.uniform(0.04, 0.12)},
    "limit_out_of_reach": lambda s, rng: {"drive_limit": 1.4 * s.peak_command},
    "rate_out_of_reach": lambda s, rng: {"drive_rate": 200.0 * s.peak_slew},
    "supply_out_of_reach": lambda s, rng: {
        "supply_limit": 1.5 * s.peak_mix * s.peak_command,
        "supply_slope": s.peak_command / s.peak_speed,
    },
    "sensor_zero": lambda s, rng: {"sensor_zero": rng.uniform(5.0, 20.0) * s.machine.quantum},
    "sensor_scale": lambda s, rng: {"sensor_scale": rng.uniform(0.01, 0.03)},
}

NEEDS_REVERSALS = {"friction_without_reversal": "coulomb_friction"}
"""Decoys that a motion in one direction hides, and the name that would be no wrong one."""
