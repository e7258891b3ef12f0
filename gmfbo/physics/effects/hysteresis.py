"""Hysteresis of gears and cables: Bouc and Wen's loop over the position."""

import math

import numpy as np

from gmfbo.physics import friction
from gmfbo.physics.effect import Effect, Values, sentence
from gmfbo.physics.states import Array, States


def _loop(position: Array, deflection: float) -> Array:
    """Follow the loop along a path, shape (n,): exact for exponent 1.

    Loading saturates exponentially, unloading is linear; a step may hold both.
    """
    result = np.zeros(len(position))
    state = 0.0
    for index, move in enumerate((np.diff(position) / deflection).tolist(), 1):
        if state * move < 0.0:
            unloaded = min(abs(move), abs(state))
            state += math.copysign(unloaded, move)
            move -= math.copysign(unloaded, move)
        if move:
            sign = math.copysign(1.0, move)
            state = sign + (state - sign) * math.exp(-abs(move))
        result[index] = state
    return result


def _signal(states: States, parameters: Values) -> Array:
    return -parameters["level"] * _loop(states.position, parameters["deflection"])


hysteresis = Effect(
    name="hysteresis",
    port="torque",
    family="friction",
    signal_path="transmission",
    parameters=(
        friction.level("Half the height of the loop"),
        friction.deflection("Deflection of the loop", friction.body_deflections),
    ),
    fixed=lambda e: {"exponent": 1.0},
    starts=lambda e: friction.starts(e, 2, friction.body_deflections),
    size=lambda p, e: p["level"],
    size_name="level",
    size_unit="torque",
    floor=friction.floor,
    not_excited=friction.no_reversal,
    signal=_signal,
    feature=lambda states: _signal(
        states, {"level": 1.0, "deflection": friction.typical_deflection(states)}
    ),
    acts=friction.acts_at_reversals,
    region=lambda p, units: "over the position, after the velocity changes sign",
    region_state="velocity",
    statement=sentence(
        "Hysteresis of about {level} {place}, closing within {deflection}, is missing from the "
        "twin.",
        level="torque",
        deflection="position",
    ),
    equation="tau = -F * z, dz/dphi = (1 - abs(z)^n * (sign(z * omega) + 1) / 2) / deflection",
    source="Wen, 1976",
    contains=("coulomb_friction",),
    as_limit={"level": "level", "deflection": "deflection"},
    confused_with={
        "presliding_friction": "the way back: a bristle turns steeper, a cable unloads elastically",
        "backlash": "fast reversals: the load strikes after crossing a gap",
        "coulomb_friction": "small reversals: Coulomb friction jumps, hysteresis bends",
        "elastic_return": "the way back: a spring returns all of its energy",
    },
)
