"""Elastic return: a spring, cable or hose that pulls the axis back."""

from gmfbo.physics.effect import Effect, Values, positive, sentence, signed
from gmfbo.physics.states import Array, States


def _signal(states: States, parameters: Values) -> Array:
    return parameters["preload"] - parameters["stiffness"] * states.position


elastic_return = Effect(
    name="elastic_return",
    port="torque",
    family="spring",
    signal_path="plant",
    parameters=(
        positive("stiffness", "Stiffness", "torque/position", lambda e: e.torque / e.stroke),
        signed("preload", "Preload", "torque", lambda e: e.torque),
    ),
    starts=lambda e: [{"stiffness": 0.07 * e.torque / e.stroke, "preload": 0.02 * e.torque}],
    size=lambda p, e: p["stiffness"],
    size_name="stiffness",
    size_unit="torque/position",
    floor=lambda e: 1.5e-4 * e.torque / e.stroke,
    signal=_signal,
    feature=lambda states: _signal(states, {"stiffness": 1.0, "preload": 0.0}),
    acts_at_rest=True,
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: "over the position, growing with the distance from rest",
    region_state="position",
    statement=sentence(
        "An elastic return {torque_word} of about {stiffness} {place} is missing from the twin.",
        stiffness="torque/position",
    ),
    equation="tau = -k * phi + tau_0",
    source="Hooke, 1678",
    contains=("constant_torque_offset",),
    as_limit={"preload": "level"},
    confused_with={
        "gravity_torque": "a large-angle sweep: gravity turns back, a spring goes on",
        "constant_torque_offset": "standstill at two positions: an offset stays",
        "hysteresis": "the way back: a spring returns all of its energy",
        "sensor_scale": "standstill away from zero: a spring asks for a holding torque",
    },
)
