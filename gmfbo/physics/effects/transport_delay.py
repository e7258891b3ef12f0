"""Transport delay: the command acts later than the twin says."""

from gmfbo.physics import timing
from gmfbo.physics.effect import Effect, Values, sentence
from gmfbo.physics.states import Array, States


def _signal(states: States, parameters: Values) -> Array:
    return timing.delayed(states.time, states.command, parameters["delay"]) - states.command


transport_delay = Effect(
    name="transport_delay",
    port="command",
    family="timing",
    signal_path="actuator",
    parameters=(timing.time_parameter("delay", "Delay", timing.longest_delay),),
    starts=lambda e: timing.starts("delay", e, timing.longest_delay),
    size=lambda p, e: p["delay"],
    size_name="delay",
    size_unit="s",
    floor=timing.floor,
    not_excited=timing.delay_too_coarse,
    signal=_signal,
    feature=lambda states: timing.lateness_feature(states.time, states.command),
    acts=timing.command_acts,
    region=lambda p, units: "where the command changes fast",
    region_state="command",
    statement=sentence(
        "A delay of about {delay} between command and actuator is missing from the twin.",
        delay="s",
    ),
    equation="u_out(t) = u(t - T_d)",
    source="Smith, 1957",
    confused_with={
        "actuator_lag": "high frequencies: a lag also lowers the amplitude, a delay only the phase",
        "sensor_lag": "the reading against the command that it causes in the controller",
        "torsional_compliance": "a chirp past the resonance: a delay has none",
    },
)
