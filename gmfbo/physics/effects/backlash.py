"""Backlash: free play between motor and load."""

import math

from gmfbo.physics import transmission
from gmfbo.physics.effect import Effect, EffectParameter, Values, sentence
from gmfbo.physics.excitation import Excitation

# Blows return 16, 53 or 85 % of the speed: dead ones first, bounces give a fit many minima.
_DAMPING_RATIOS = (0.5, 0.2, 0.05)


def _unit(excitation: Excitation) -> float:
    # 0.4 mrad on a shaft and 20 um on a linear axis, less where the stroke itself is small.
    least = 4e-4 if excitation.angular else 2e-5
    return max(3.0 * excitation.resolution, min(least, 4e-4 * excitation.stroke))


def _fixed(excitation: Excitation, damping_ratio: float = _DAMPING_RATIOS[0]) -> Values:
    # With this stiffness, the contact's own deflection is far below any gap that is claimed.
    stiffness = excitation.torque / (0.1 * _unit(excitation))
    # Motor and load of equal shares meet as a quarter of the inertia.
    own = math.sqrt(stiffness * 0.25 * excitation.shaft_inertia)
    return {"stiffness": stiffness, "damping": 2.0 * damping_ratio * own}


def _starts(excitation: Excitation) -> list[Values]:
    unit, inertia = _unit(excitation), excitation.shaft_inertia
    grid = ((0.7, 0.5), (2.5, 0.5), (6.0, 0.5), (15.0, 0.5), (6.0, 0.2))
    return [{"gap": g * unit, "load_inertia": share * inertia} for g, share in grid]


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
    fixed_otherwise=lambda e: [_fixed(e, ratio) for ratio in _DAMPING_RATIOS[1:]],
    starts=_starts,
    inertia_share=True,
    size=lambda p, e: p["gap"],
    size_name="gap",
    size_unit="position",
    floor=lambda e: max(2.0 * e.resolution, 0.2 * _unit(e)),
    not_excited=_not_excited,
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
