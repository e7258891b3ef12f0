"""Sensor lag: the reading follows the position with a time constant."""

from gmfbo.physics import timing
from gmfbo.physics.effect import Effect, Values, sentence
from gmfbo.physics.states import Array, States


def _signal(states: States, parameters: Values) -> Array:
    return timing.lagged(states.time, states.position, parameters["time"]) - states.position


sensor_lag = Effect(
    name="sensor_lag",
    port="sensor",
    family="timing",
    signal_path="sensor",
    parameters=(timing.time_parameter("time", "Time constant"),),
    starts=lambda e: timing.starts("time", e),
    size=lambda p, e: p["time"],
    size_name="time",
    size_unit="s",
    floor=timing.floor,
    signal=_signal,
    feature=lambda states: -states.velocity,
    acts=lambda states, p: timing.acts_in_fast_change(states.time, states.position),
    region=lambda p, units: "in fast motion, in proportion to the velocity",
    region_state="velocity",
    statement=sentence(
        "A lag of the position sensor of about {time} is missing from the twin.",
        time="s",
    ),
    equation="T * d(reading)/dt = phi - reading",
    source="Fraden, 1993",
    confused_with={
        "actuator_lag": "the reading against the command that it causes in the controller",
        "transport_delay": "the reading against the command that it causes in the controller",
    },
)
