"""Coulomb friction: a constant torque against the motion."""

from gmfbo.physics import friction
from gmfbo.physics.effect import Effect, Values, sentence
from gmfbo.physics.states import Array, States


def _signal(states: States, parameters: Values) -> Array:
    return -parameters["level"] * states.direction


coulomb_friction = Effect(
    name="coulomb_friction",
    port="torque",
    family="friction",
    signal_path="plant",
    parameters=(friction.level("Coulomb level"),),
    fixed=friction.fixed_deflection,
    own_nuisances=(friction.own_deflection(),),
    starts=lambda e: [{"level": 0.07 * e.torque}],
    size=lambda p, e: p["level"],
    size_name="level",
    size_unit="torque",
    floor=friction.floor,
    not_excited=friction.no_reversal,
    signal=_signal,
    feature=lambda states: _signal(states, {"level": 1.0}),
    acts=friction.acts_at_reversals,
    region=friction.reversal_region,
    region_state="velocity",
    statement=sentence(
        "Coulomb friction of about {level} {place} is missing from the twin.",
        level="torque",
    ),
    equation="tau = -F_c * sign(omega)",
    source="Coulomb, 1785",
    confused_with={
        "stribeck_friction": "the friction at low speed: reversals at several speeds",
        "asymmetric_friction": "motion in both directions at equal speeds",
        "viscous_friction": "constant speeds: Coulomb friction does not grow with speed",
        "backlash": "slow reversals at two amplitudes: friction acts in between as well",
        "constant_torque_offset": "a reversal: friction changes its sign there",
    },
)
