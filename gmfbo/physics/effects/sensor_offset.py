"""Sensor offset: the reading is wrong by a constant."""

import numpy as np

from gmfbo.physics import sensor
from gmfbo.physics.effect import Effect, Values, sentence, signed
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, States


def _size(excitation: Excitation) -> float:
    return max(0.02 * excitation.stroke, 3.0 * sensor.floor(excitation))


def _signal(states: States, parameters: Values) -> Array:
    return np.full(len(states.time), float(parameters["level"]))


sensor_offset = Effect(
    name="sensor_offset",
    port="sensor",
    family="sensor",
    signal_path="sensor",
    parameters=(signed("level", "Offset", "position", _size, most=30.0, typical=0.5),),
    starts=lambda e: [{"level": _size(e)}],
    size=lambda p, e: abs(p["level"]),
    size_name="level",
    size_unit="position",
    floor=lambda e: max(5.0 * e.resolution, 5e-4 * e.stroke),
    signal=_signal,
    feature=lambda states: _signal(states, {"level": 1.0}),
    acts_at_rest=True,
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: "at all times, whatever position and velocity",
    region_state="time",
    statement=sentence(
        "An offset of the position sensor of about {level} is missing from the twin.",
        level="position",
    ),
    equation="reading = phi + phi_0",
    source="Fraden, 1993",
    confused_with={
        "constant_torque_offset": "the holding torque: a sensor offset asks for none",
        "sensor_scale": "two positions: an offset is the same at both",
    },
    parameter_like=("sensor_offset",),
)
