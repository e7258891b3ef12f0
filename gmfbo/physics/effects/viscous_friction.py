"""Viscous friction: a torque against the motion that grows with speed."""

from gmfbo.physics.effect import Effect, Values, positive, sentence
from gmfbo.physics.states import Array, States


def _signal(states: States, parameters: Values) -> Array:
    return -parameters["coefficient"] * states.velocity


viscous_friction = Effect(
    name="viscous_friction",
    port="torque",
    family="friction",
    signal_path="plant",
    parameters=(
        positive(
            "coefficient", "Viscous coefficient", "torque/velocity", lambda e: e.torque / e.speed
        ),
    ),
    starts=lambda e: [{"coefficient": 0.07 * e.torque / e.speed}],
    size=lambda p, e: p["coefficient"],
    size_name="coefficient",
    size_unit="torque/velocity",
    floor=lambda e: 1.5e-4 * e.torque / e.speed,
    signal=_signal,
    feature=lambda states: _signal(states, {"coefficient": 1.0}),
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: "at all times, in proportion to the velocity",
    region_state="velocity",
    statement=sentence(
        "Viscous friction of about {coefficient} {place} is missing from the twin.",
        coefficient="torque/velocity",
    ),
    equation="tau = -c * omega",
    source="Reynolds, 1886",
    confused_with={
        "coulomb_friction": "constant speeds: viscous friction doubles with the speed",
        "quadratic_drag": "three constant speeds, the highest as high as is safe",
        "actuator_gain_loss": "a gain loss also shows while accelerating at low speed",
    },
    parameter_like=("viscous_friction",),
)
