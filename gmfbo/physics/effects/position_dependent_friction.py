"""Position-dependent friction: a tight spot in a bearing, screw or guide."""

import math

import numpy as np

from gmfbo.physics import friction, harmonic
from gmfbo.physics.effect import Effect, Units, Values, signed
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, Mask, States
from gmfbo.units import quantity


def _level(states: States, parameters: Values) -> Array:
    sine, cosine = parameters["sine"], parameters["cosine"]
    varying = harmonic.wave(states, parameters["wavenumber"], sine, cosine)
    return np.maximum(0.0, parameters["level"] + varying)


def _starts(excitation: Excitation) -> list[Values]:
    once = 1.0 if excitation.angular else 2.0 * math.pi / excitation.stroke
    level = 0.06 * excitation.torque
    return [
        {"level": level, "sine": 0.4 * level, "cosine": 0.4 * level, "wavenumber": line}
        for line in (once, *excitation.wavenumbers[:2])
    ]


def _low(excitation: Excitation) -> float:
    return min(0.5, 0.5 * math.pi / excitation.stroke, *(0.5 * w for w in excitation.wavenumbers))


def _acts(states: States, parameters: Values) -> Mask:
    level = _level(states, parameters)
    tight = level >= 0.5 * (float(np.max(level)) + float(np.min(level)))
    return states.near_reversals() | (tight & (np.abs(states.velocity) > states.rest))


def _statement(parameters: Values, units: Units, place: str) -> str:
    swing = harmonic.amplitude(parameters)
    least = quantity(max(0.0, parameters["level"] - swing), units.torque)
    most = quantity(parameters["level"] + swing, units.torque)
    often = harmonic.cycles(parameters["wavenumber"], units.position == "rad")
    return (
        f"Friction that depends on the position {place} is missing from the twin: "
        f"between {least} and {most}, {often}."
    )


position_dependent_friction = Effect(
    name="position_dependent_friction",
    port="torque",
    family="friction",
    signal_path="plant",
    parameters=(
        friction.level("Mean friction"),
        signed("sine", "Sine amplitude", "torque", lambda e: e.torque),
        signed("cosine", "Cosine amplitude", "torque", lambda e: e.torque),
        harmonic.wavenumber(low=_low),
    ),
    fixed=friction.fixed_deflection,
    own_nuisances=(friction.own_deflection(),),
    starts=_starts,
    size=lambda p, e: p["level"] + harmonic.amplitude(p),
    size_name="level",
    size_unit="torque",
    floor=friction.floor,
    not_excited=friction.no_reversal,
    signal=lambda states, p: -_level(states, p) * states.direction,
    acts=_acts,
    region=lambda p, units: (
        "over the position while the velocity is not zero, "
        + harmonic.cycles(p["wavenumber"], units.position == "rad")
    ),
    region_state="position",
    statement=_statement,
    equation="tau = -max(0, F_c + A * sin(n * phi) + B * cos(n * phi)) * sign(omega)",
    source="Popovic and Goldenberg, 1998",
    contains=("coulomb_friction",),
    as_limit={"level": "level"},
    confused_with={
        "coulomb_friction": "slow passes over the whole stroke in both directions",
        "cogging_torque": "passes in both directions: friction changes its sign, cogging does not",
        "gravity_torque": "passes in both directions: friction changes its sign, gravity does not",
    },
)
