"""Coulomb friction: a constant torque against the motion."""

from gmfbo.physics import friction
from gmfbo.physics.effect import Effect, Units, Values
from gmfbo.physics.states import Array, States
from gmfbo.units import quantity


def _signal(states: States, parameters: Values) -> Array:
    return -parameters["level"] * states.direction


def _statement(parameters: Values, units: Units, place: str) -> str:
    size = quantity(parameters["level"], units.torque)
    return f"Coulomb friction of about {size} {place} is missing from the twin."


coulomb_friction = Effect(
    name="coulomb_friction",
    port="torque",
    family="friction",
    signal_path="plant",
    parameters=(friction.level("Coulomb level"),),
    fixed=friction.fixed_deflection,
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
    statement=_statement,
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
