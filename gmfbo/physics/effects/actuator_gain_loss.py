"""Gain loss: the actuator gives less than the command asks for."""

from gmfbo.physics.effect import Effect, EffectParameter, Units, Values
from gmfbo.physics.states import Array, States
from gmfbo.units import percent


def _signal(states: States, parameters: Values) -> Array:
    return -parameters["loss"] * states.command


def _statement(parameters: Values, units: Units, place: str) -> str:
    loss = parameters["loss"]
    less = "less" if loss >= 0.0 else "more"
    return f"The actuator gives about {percent(abs(loss))} {less} than the twin's does."


actuator_gain_loss = Effect(
    name="actuator_gain_loss",
    port="command",
    family="gain",
    signal_path="actuator",
    parameters=(
        EffectParameter(
            "loss",
            "Loss",
            "1",
            low=lambda e: -0.5,
            high=lambda e: 0.9,
            scale=lambda e: 0.07,
        ),
    ),
    starts=lambda e: [{"loss": 0.08}],
    size=lambda p, e: abs(p["loss"]),
    size_name="loss",
    size_unit="1",
    floor=lambda e: 0.045,  # torque constants are off by 2 %: 2.25 standard deviations
    signal=_signal,
    feature=lambda states: _signal(states, {"loss": 1.0}),
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: "at all times, in proportion to the command",
    region_state="command",
    statement=_statement,
    equation="u_out = (1 - loss) * u",
    source="Isermann, 2006",
    confused_with={
        "magnetic_saturation": "small and large commands: a gain takes the same share of both",
        "thermal_derating": "early and late: a gain does not change with time",
        "load_inertia": "steady speed: an inertia asks for nothing there",
        "viscous_friction": "acceleration at low speed, where viscous friction is small",
    },
    parameter_like=("gain",),
)
