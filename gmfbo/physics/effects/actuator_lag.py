"""Actuator lag: the current loop or valve follows with a time constant."""

from gmfbo.physics import timing
from gmfbo.physics.effect import Effect, sentence

actuator_lag = Effect(
    name="actuator_lag",
    port="command",
    family="timing",
    signal_path="actuator",
    parameters=(timing.time_parameter("time", "Time constant"),),
    starts=lambda e: timing.starts("time", e),
    size=lambda p, e: p["time"],
    size_name="time",
    size_unit="s",
    floor=timing.floor,
    signal=lambda states, p: timing.lagged(states.time, states.command, p["time"]) - states.command,
    feature=lambda states: timing.lateness_feature(states.time, states.command),
    acts=timing.command_acts,
    region=lambda p, units: "where the command changes fast",
    region_state="command",
    statement=sentence(
        "An actuator lag with a time constant of about {time} is missing from the twin.",
        time="s",
    ),
    equation="T * d(u_out)/dt = u - u_out",
    source="Leonhard, 1985",
    confused_with={
        "transport_delay": "high frequencies: a lag also lowers the amplitude",
        "sensor_lag": "the reading against the command that it causes in the controller",
        "actuator_rate_limit": "small fast commands, which a rate limit passes",
        "torsional_compliance": "a chirp past the resonance: a lag has none",
    },
)
