"""Sensor scale: the reading is wrong by a share of the position."""

from gmfbo.physics.effect import Effect, EffectParameter, Units, Values
from gmfbo.physics.states import Array, States
from gmfbo.units import percent

_MOST = 0.3  # largest relative error of a sensor


def _signal(states: States, parameters: Values) -> Array:
    return parameters["share"] * states.position


def _statement(parameters: Values, units: Units, place: str) -> str:
    share = parameters["share"]
    more = "more" if share >= 0.0 else "less"
    return f"The position sensor reads about {percent(abs(share))} {more} than the twin's does."


sensor_scale = Effect(
    name="sensor_scale",
    port="sensor",
    family="sensor",
    signal_path="sensor",
    parameters=(
        EffectParameter(
            "share",
            "Share of the position",
            "1",
            low=lambda e: -_MOST,
            high=lambda e: _MOST,
            scale=lambda e: 0.02,
        ),
    ),
    # In a loop, a scale error of a tenth shifts a resonance far, where derivatives are no guide:
    # both signs are tried.
    starts=lambda e: [{"share": 0.03}, {"share": 0.1}, {"share": -0.1}],
    size=lambda p, e: abs(p["share"]),
    size_name="share",
    size_unit="1",
    floor=lambda e: 0.002,
    signal=_signal,
    feature=lambda states: _signal(states, {"share": 1.0}),
    acts_at_rest=True,
    acts=lambda states, p: states.everywhere(),
    region=lambda p, units: "at all times, in proportion to the position",
    region_state="position",
    statement=_statement,
    equation="reading = (1 + s) * phi",
    source="Fraden, 1993",
    confused_with={
        "sensor_offset": "two positions: an offset is the same at both",
        "sensor_eccentricity": "a whole turn: eccentricity comes back, a scale error does not",
        "elastic_return": "standstill away from zero: a spring asks for a holding torque",
    },
    parameter_like=("sensor_scale",),
)
