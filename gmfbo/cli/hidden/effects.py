"""Effects that the demo may hide: in the plant, and in a diagnosis.

The plant's laws are not those of the catalogue (hard friction, contact by Hunt and Crossley, delays
off the grid), so only values that mean the same in both are compared. A limit of the command's rate
is left out: such a limit either has no effect in this loop or makes it unstable.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

Rng = np.random.Generator
Values = Mapping[str, float]

# Largest torque over inertia that the references ask of the rigid axis. A torque limit has to be
# below it, but not far, or the axis would not follow at all.
_HARDEST = 350.0  # [rad/s2]


@dataclass(frozen=True)
class Size:
    """A size of a hidden effect, as the plant has it and as a diagnosis reports it.

    Attributes
    ----------
    name : str
        For people.
    unit : str
        Of both values.
    true : callable
        From the plant's parameters.
    found : callable
        From the effect's identified parameters.
    """

    name: str
    unit: str
    true: Callable[[Values], float]
    found: Callable[[Values], float]


@dataclass(frozen=True)
class HiddenEffect:
    """One effect of the catalogue, and its range of sizes in the plant.

    Attributes
    ----------
    name : str
        Name in the catalogue.
    draw : callable
        From a generator and the rigid plant's parameters to those that switch the effect on.
    sizes : tuple of Size
        Sizes to compare with a diagnosis.
    """

    name: str
    draw: Callable[[Rng, Values], dict[str, float]]
    sizes: tuple[Size, ...]


def log_uniform(rng: Rng, low: float, high: float) -> float:
    """Draw a size from a log-uniform distribution."""
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))


def _angle(rng: Rng) -> float:
    return float(rng.uniform(-math.pi, math.pi))


def _signed(rng: Rng, size: float) -> float:
    return size if rng.random() < 0.5 else -size


def _amplitude(sine: str, cosine: str) -> Callable[[Values], float]:
    return lambda values: math.hypot(values[sine], values[cosine])


def _value(name: str) -> Callable[[Values], float]:
    return lambda values: values[name]


def _coulomb(rng: Rng, rigid: Values) -> dict[str, float]:
    level = log_uniform(rng, 0.15, 0.6)
    return {"friction.forward": level, "friction.backward": level}


def _asymmetric(rng: Rng, rigid: Values) -> dict[str, float]:
    low = log_uniform(rng, 0.12, 0.35)
    levels = [low, low * log_uniform(rng, 1.6, 3.0)]
    forward, backward = levels if rng.random() < 0.5 else levels[::-1]
    return {"friction.forward": forward, "friction.backward": backward}


def _stribeck(rng: Rng, rigid: Values) -> dict[str, float]:
    level = log_uniform(rng, 0.12, 0.35)
    return {
        "friction.forward": level,
        "friction.backward": level,
        "friction.breakaway": level * log_uniform(rng, 0.6, 1.5),
        "friction.stribeck_velocity": log_uniform(rng, 0.3, 1.2),
    }


def _backlash(rng: Rng, rigid: Values) -> dict[str, float]:
    return {
        "load.inertia": rigid["inertia"] * float(rng.uniform(0.35, 0.6)),
        "gap": log_uniform(rng, 5e-3, 0.03),
    }


def _belt(rng: Rng, rigid: Values) -> dict[str, float]:
    load = rigid["inertia"] * float(rng.uniform(0.35, 0.6))
    own = 2.0 * math.pi * log_uniform(rng, 18.0, 45.0)  # [rad/s] of the load, motor held
    damping = 2.0 * log_uniform(rng, 0.03, 0.1) * load * own
    return {"load.inertia": load, "belt.stiffness": load * own**2, "belt.damping": damping}


def _cogging(rng: Rng, rigid: Values) -> dict[str, float]:
    return {
        "ripple.torque": log_uniform(rng, 0.1, 0.4),
        "ripple.cycles": float(rng.integers(6, 25)),
        "ripple.phase": _angle(rng),
    }


def _gravity(rng: Rng, rigid: Values) -> dict[str, float]:
    return {"arm.torque": log_uniform(rng, 0.2, 1.0), "arm.angle": _angle(rng)}


def _spring(rng: Rng, rigid: Values) -> dict[str, float]:
    return {
        "spring.stiffness": log_uniform(rng, 0.2, 1.0),
        "spring.rest": float(rng.uniform(-0.5, 0.5)),
    }


def _hum(rng: Rng, rigid: Values) -> dict[str, float]:
    return {
        "hum.torque": log_uniform(rng, 0.1, 0.4),
        "hum.frequency": log_uniform(rng, 6.0, 50.0),
        "hum.phase": _angle(rng),
    }


EFFECTS: tuple[HiddenEffect, ...] = (
    HiddenEffect(
        "coulomb_friction",
        _coulomb,
        (Size("level", "N.m", _value("friction.forward"), _value("level")),),
    ),
    HiddenEffect(
        "stribeck_friction",
        _stribeck,
        (
            Size("level", "N.m", _value("friction.forward"), _value("level")),
            Size(
                "breakaway",
                "N.m",
                lambda plant: plant["friction.forward"] + plant["friction.breakaway"],
                _value("breakaway"),
            ),
            Size("velocity", "rad/s", _value("friction.stribeck_velocity"), _value("velocity")),
        ),
    ),
    HiddenEffect(
        "asymmetric_friction",
        _asymmetric,
        (
            Size("forward", "N.m", _value("friction.forward"), _value("level_positive")),
            Size("backward", "N.m", _value("friction.backward"), _value("level_negative")),
        ),
    ),
    HiddenEffect(
        "quadratic_drag",
        lambda rng, rigid: {"drag": log_uniform(rng, 2e-3, 0.01)},
        (Size("coefficient", "N.m.s2/rad2", _value("drag"), _value("coefficient")),),
    ),
    HiddenEffect(
        "backlash",
        _backlash,
        (
            Size("gap", "rad", _value("gap"), _value("gap")),
            Size("load inertia", "kg.m2", _value("load.inertia"), _value("load_inertia")),
        ),
    ),
    HiddenEffect(
        "torsional_compliance",
        _belt,
        (
            Size("stiffness", "N.m/rad", _value("belt.stiffness"), _value("stiffness")),
            Size("load inertia", "kg.m2", _value("load.inertia"), _value("load_inertia")),
        ),
    ),
    HiddenEffect(
        "cogging_torque",
        _cogging,
        (
            Size("amplitude", "N.m", _value("ripple.torque"), _amplitude("sine_1", "cosine_1")),
            Size("cycles a turn", "1", _value("ripple.cycles"), _value("wavenumber_1")),
        ),
    ),
    HiddenEffect(
        "gravity_torque",
        _gravity,
        (Size("amplitude", "N.m", _value("arm.torque"), _amplitude("sine", "cosine")),),
    ),
    HiddenEffect(
        "elastic_return",
        _spring,
        (Size("stiffness", "N.m/rad", _value("spring.stiffness"), _value("stiffness")),),
    ),
    HiddenEffect(
        "constant_torque_offset",
        lambda rng, rigid: {"push": _signed(rng, log_uniform(rng, 0.15, 0.6))},
        (Size("level", "N.m", _value("push"), _value("level")),),
    ),
    HiddenEffect(
        "periodic_disturbance",
        _hum,
        (
            Size("amplitude", "N.m", _value("hum.torque"), _amplitude("sine", "cosine")),
            Size("frequency", "Hz", _value("hum.frequency"), _value("frequency")),
        ),
    ),
    HiddenEffect(
        "actuator_saturation",
        lambda rng, rigid: {
            "drive.limit": _HARDEST * rigid["inertia"] * log_uniform(rng, 0.75, 0.88)
        },
        (Size("limit", "N.m", _value("drive.limit"), _value("limit")),),
    ),
    HiddenEffect(
        "actuator_dead_zone",
        lambda rng, rigid: {"drive.dead_zone": log_uniform(rng, 0.1, 0.4)},
        (Size("width", "N.m", _value("drive.dead_zone"), _value("width")),),
    ),
    HiddenEffect(
        "actuator_lag",
        lambda rng, rigid: {"drive.lag": log_uniform(rng, 1e-3, 3e-3)},
        (Size("time constant", "s", _value("drive.lag"), _value("time")),),
    ),
    HiddenEffect(
        "transport_delay",
        lambda rng, rigid: {"drive.delay": log_uniform(rng, 1e-3, 3e-3)},
        (Size("delay", "s", _value("drive.delay"), _value("delay")),),
    ),
)
