"""A constant torque: weight on a vertical axis, or the offset of an amplifier."""

import numpy as np

from gmfbo.physics.effect import Effect, Values, sentence, signed
from gmfbo.physics.states import Array, States


def _signal(states: States, parameters: Values) -> Array:
    return np.full(len(states.time), float(parameters["level"]))


constant_torque_offset = Effect(
    name="constant_torque_offset",
    port="torque",
    family="disturbance",
    signal_path="plant",
    parameters=(signed("level", "Level", "torque", lambda e: e.torque),),
    starts=lambda e: [{"level": 0.07 * e.torque}],
    size=lambda p, e: abs(p["level"]),
    size_name="level",
    size_unit="torque",
    floor=lambda e: 1.5e-4 * e.torque,
    signal=_signal,
    feature=lambda states: _signal(states, {"level": 1.0}),
    acts_at_rest=True,
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: "at all times, whatever position and velocity",
    region_state="time",
    statement=sentence(
        "A constant {torque_word} of about {level} {place} is missing from the twin.",
        level="torque",
    ),
    equation="tau = tau_0",
    source="Newton, 1687",
    confused_with={
        "coulomb_friction": "a reversal: friction changes its sign there",
        "asymmetric_friction": "standstill: an offset is still there, friction only yields",
        "gravity_torque": "a large-angle sweep: an offset stays",
        "elastic_return": "standstill at two positions: an offset stays",
        "sensor_offset": "the holding torque: a sensor offset asks for none",
    },
)
