"""Backlash: free play between motor and load."""

import math

from gmfbo.physics import transmission
from gmfbo.physics.effect import Effect, EffectParameter, Values, sentence
from gmfbo.physics.excitation import Excitation

# Blows return 16 % of the speed, or 85 %: a fit does not come from one to the other.
_DEAD, _BOUNCING = 0.5, 0.05  # damping ratio of a contact
_LEAST, _MOST = 0.005, 0.9  # the same
_SMALL = 15.0  # units: gaps of machines
_SOFT = 100.0  # times softer: gears, couplings and belts give as much as their play


def _unit(excitation: Excitation) -> float:
    # 0.4 mrad on a shaft and 20 um on a linear axis, less where the stroke itself is small.
    least = 4e-4 if excitation.angular else 2e-5
    return max(3.0 * excitation.resolution, min(least, 4e-4 * excitation.stroke))


def _stiffness(excitation: Excitation) -> float:
    """Of a contact whose own deflection is far below any gap that is claimed."""
    return excitation.torque / (0.1 * _unit(excitation))


def _damping(excitation: Excitation, ratio: float, softer: float = 1.0) -> float:
    # Motor and load of equal shares meet as a quarter of the inertia.
    stiffness = _stiffness(excitation) / softer
    return 2.0 * ratio * math.sqrt(stiffness * 0.25 * excitation.shaft_inertia)


def _fixed(excitation: Excitation) -> Values:
    return {"stiffness": _stiffness(excitation), "damping": _damping(excitation, _DEAD)}


def _starts(excitation: Excitation) -> list[Values]:
    unit, most = _unit(excitation), 0.2 * excitation.stroke
    # Small gaps show where their load bounces, large ones where it does not strike hard.
    grid = (
        (1.0, _BOUNCING, (0.2, 0.7, 2.5)),
        (1.0, _DEAD, (0.7, 2.5, 6.0, 15.0)),
        (_SOFT, _DEAD, (6.0, 15.0, 30.0, 80.0)),
        (_SOFT, _BOUNCING, (30.0,)),
    )
    return [
        {
            "gap": gap * unit,
            "load_inertia": 0.5 * excitation.shaft_inertia,
            "stiffness": _stiffness(excitation) / softer,
            "damping": _damping(excitation, ratio, softer),
        }
        for softer, ratio, gaps in grid
        for gap in gaps
        if gap <= _SMALL or gap * unit < most
    ]


def _not_excited(excitation: Excitation) -> str | None:
    if excitation.reversals == 0:
        return "no reversal of the velocity"
    return transmission.unknown_inertia(excitation)


backlash = Effect(
    name="backlash",
    port="torque",
    family="spring",
    signal_path="transmission",
    parameters=(
        EffectParameter(
            "gap",
            "Effective gap, total free play",
            "position",
            low=lambda e: 0.0,
            high=lambda e: max(0.5 * e.stroke, 30.0 * _unit(e)),
            scale=lambda e: 3.0 * _unit(e),
        ),
        transmission.load_inertia(),
    ),
    fixed=_fixed,
    own_nuisances=(
        EffectParameter(
            "stiffness",
            "Stiffness of the contact",
            "torque/position",
            low=lambda e: _stiffness(e) / _SOFT**1.5,
            high=lambda e: 10.0 * _stiffness(e),
            scale=_stiffness,
            hidden=True,
        ),
        EffectParameter(
            "damping",
            "Damping of the contact",
            "torque/velocity",
            low=lambda e: _damping(e, _LEAST, _SOFT),
            high=lambda e: _damping(e, _MOST),
            scale=lambda e: _damping(e, _BOUNCING),
            hidden=True,
        ),
    ),
    starts=_starts,
    inertia_share=True,
    begins_whole=True,
    size=lambda p, e: p["gap"],
    size_name="gap",
    size_unit="position",
    floor=lambda e: 0.05 * _unit(e),
    not_excited=_not_excited,
    shows_at_turns=True,
    acts=lambda states, p: states.near_reversals(),
    region=lambda p, units: "where the velocity changes sign",
    region_state="velocity",
    statement=sentence(
        "Backlash with an effective gap of about {gap} behind the motor is missing from the twin.",
        gap="position",
    ),
    equation="tau = -k * deadzone(phi - phi_load, gap) - d * (omega - omega_load) in contact",
    source="Nordin and Gutman, 2002",
    confused_with={
        "coulomb_friction": "slow reversals at two amplitudes: the gap acts at the reversal only",
        "torsional_compliance": "small motion: a shaft gives torque at once, a gap gives none",
        "presliding_friction": "micro-steps: a gap gives no torque back, a bristle does",
        "hysteresis": "fast reversals: the load strikes after crossing a gap",
    },
    parameter_like=("inertia",),
)
