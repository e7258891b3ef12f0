"""Torsional compliance: an elastic shaft, belt or coupling between motor and load."""

import math

from gmfbo.physics import transmission
from gmfbo.physics.effect import Effect, EffectParameter, Values, sentence
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.timing import acts_in_fast_change

_SHARE = 0.5  # of the inertia at the load, where the stiffness range is laid out
_DAMPING_RATIO = 0.05


def _stiffness(excitation: Excitation, along: float) -> float:
    """Stiffness at a place `along` 0 to 1, even in the logarithm of the load's frequency.

    From twice as slow as the loop to what the recording resolves.
    """
    fast = 1.0 / excitation.sample
    slow = min(0.5 / excitation.loop_time, 0.05 * fast)
    frequency = math.exp((1.0 - along) * math.log(slow) + along * math.log(fast))  # [rad/s]
    return _SHARE * excitation.shaft_inertia * frequency**2


def _damping(stiffness: float, excitation: Excitation) -> float:
    """Damping of a typical ratio at this stiffness."""
    inertia = _SHARE * (1.0 - _SHARE) * excitation.shaft_inertia
    return 2.0 * _DAMPING_RATIO * math.sqrt(stiffness * inertia)


def _starts(excitation: Excitation) -> list[Values]:
    stiffnesses = [_stiffness(excitation, along) for along in (0.2, 0.5, 0.8)]
    load = _SHARE * excitation.shaft_inertia
    return [
        {"stiffness": k, "load_inertia": load, "damping": _damping(k, excitation)}
        for k in stiffnesses
    ]


def _windup(parameters: Values, excitation: Excitation) -> float:
    share = parameters["load_inertia"] / excitation.shaft_inertia
    return share * excitation.torque / parameters["stiffness"]


torsional_compliance = Effect(
    name="torsional_compliance",
    port="torque",
    family="spring",
    signal_path="transmission",
    parameters=(
        EffectParameter(
            "stiffness",
            "Stiffness",
            "torque/position",
            low=lambda e: _stiffness(e, 0.0),
            high=lambda e: _stiffness(e, 1.0),
            scale=lambda e: _stiffness(e, 0.4),
        ),
        transmission.load_inertia(),
        EffectParameter(
            "damping",
            "Damping",
            "torque/velocity",
            low=lambda e: 0.0,
            high=lambda e: 20.0 * _damping(_stiffness(e, 1.0), e),
            scale=lambda e: _damping(_stiffness(e, 0.6), e),
            hidden=True,
        ),
    ),
    starts=_starts,
    inertia_share=True,
    size=_windup,
    size_name="windup",
    size_unit="position",
    floor=lambda e: 2.0 * e.resolution,
    not_excited=transmission.unknown_inertia,
    acts=lambda states, p: acts_in_fast_change(states.time, states.velocity),
    region=lambda p, units: "in fast motion, where the acceleration is high",
    region_state="acceleration",
    statement=sentence(
        "Compliance of the transmission is missing from the twin: a stiffness of about "
        "{stiffness} between the motor and a load of {load_inertia}.",
        stiffness="torque/position",
        load_inertia="inertia",
    ),
    equation="tau = -k * (phi - phi_load) - d * (omega - omega_load)",
    source="Spong, 1987",
    confused_with={
        "backlash": "small motion: a shaft gives torque at once, a gap gives none",
        "transport_delay": "a chirp past the resonance: a delay has none",
        "actuator_lag": "a chirp past the resonance: a lag has none",
        "load_inertia": "slow and fast motion: stiff when slow, the load is left behind when fast",
    },
    parameter_like=("inertia",),
)
