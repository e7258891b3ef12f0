"""Hysteresis of gears and cables: Maxwell slip over the position.

Elements in parallel, each a spring that slips at its own travel. The way back from a reversal is
the first loading at twice its size (Masing 1926), and a small loop within a large one closes (Iwan
1966, A distributed-element model for hysteresis). Bouc and Wen's equation does neither.
"""

from itertools import pairwise

import numpy as np
from scipy.special import gammaincinv

from gmfbo.physics import friction
from gmfbo.physics.effect import Effect, Values, sentence
from gmfbo.physics.states import Array, States

_ELEMENTS = 16
# Travel at which each slips, over the deflection: with equal forces a first loading of many is
# 1 - exp(-travel / deflection), and of these the same to 0.006.
_TRAVELS = gammaincinv(2.0, (np.arange(_ELEMENTS) + 0.5) / _ELEMENTS)


def _loop(position: Array, deflection: float) -> Array:
    """Mean stretch of the elements along a path, shape (n,), -1 to 1."""
    travel = np.concatenate([[0.0], np.cumsum(np.diff(position) / deflection)])
    # Between two reversals each element stretches with the travel until it slips.
    moves = np.flatnonzero(np.diff(travel))
    turns = moves[1:][np.diff(travel)[moves[1:]] * np.diff(travel)[moves[:-1]] < 0.0]
    ends = [0, *turns.tolist(), len(position) - 1]
    result, stretch = np.zeros(len(position)), np.zeros(_ELEMENTS)
    for begin, end in pairwise(ends):
        part = (travel[begin + 1 : end + 1, None] - travel[begin]) / _TRAVELS
        along = np.clip(stretch + part, -1.0, 1.0)
        if len(along):
            result[begin + 1 : end + 1], stretch = along.mean(axis=1), along[-1]
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
        friction.deflection(
            "Travel in which a first loading comes within 1/e of the level",
            friction.body_deflections,
            typical=lambda e: 2.0 * friction.contact_deflections(e)[1],
        ),
    ),
    starts=lambda e: friction.starts(e, 3, friction.body_deflections),
    size=lambda p, e: p["level"],
    size_name="level",
    size_unit="torque",
    floor=friction.floor,
    not_excited=friction.no_reversal,
    shows_at_turns=True,
    signal=_signal,
    feature=lambda states: _signal(
        states, {"level": 1.0, "deflection": friction.typical_deflection(states)}
    ),
    acts=friction.acts_at_reversals,
    region=lambda p, units: "over the position, after the velocity changes sign",
    region_state="velocity",
    statement=sentence(
        "Hysteresis of about {level} {place}, building up over about {deflection}, is missing "
        "from the twin.",
        level="torque",
        deflection="position",
    ),
    equation="tau = -F * mean(z_i), dz_i/dphi = 1 / (x_i * deflection) up to abs(z_i) = 1, "
    "16 x_i from 0.27 to 5.3",
    source="Iwan, 1966",
    contains=("coulomb_friction",),
    as_limit={"level": "level", "deflection": "deflection"},
    confused_with={
        "presliding_friction": "the way back: a bristle turns steeper, a cable bends as at first",
        "backlash": "fast reversals: the load strikes after crossing a gap",
        "coulomb_friction": "small reversals: Coulomb friction jumps, hysteresis bends",
        "elastic_return": "the way back: a spring returns all of its energy",
    },
)
