"""Load inertia: a mass on the axis that the twin does not carry."""

import numpy as np

from gmfbo.physics.effect import Effect, Units, Values, positive
from gmfbo.physics.states import Array, Mask, States
from gmfbo.units import quantity


def _signal(states: States, parameters: Values) -> Array:
    return -parameters["inertia"] * states.acceleration


def _acts(states: States, parameters: Values) -> Mask:
    size = np.abs(states.acceleration)
    return np.asarray(size > 0.5 * np.quantile(size, 0.95), dtype=np.bool_)


def _statement(parameters: Values, units: Units, place: str) -> str:
    size = quantity(parameters["inertia"], units.resolve("inertia"))
    word = "inertia" if units.position == "rad" else "mass"
    return f"A load {word} of about {size} {place} is missing from the twin."


load_inertia = Effect(
    name="load_inertia",
    port="torque",
    family="inertia",
    signal_path="plant",
    parameters=(positive("inertia", "Load inertia", "inertia", lambda e: e.shaft_inertia),),
    starts=lambda e: [{"inertia": 0.1 * e.shaft_inertia}],
    size=lambda p, e: p["inertia"],
    size_name="inertia",
    size_unit="inertia",
    floor=lambda e: 0.01 * e.shaft_inertia,
    signal=_signal,
    feature=lambda states: _signal(states, {"inertia": 1.0}),
    acts=_acts,
    region=lambda p, units: "where the acceleration is high",
    region_state="acceleration",
    statement=_statement,
    equation="tau = -J * d(omega)/dt",
    source="Euler, 1752",
    confused_with={
        "torsional_compliance": "slow and fast motion: an elastic load is left behind when fast",
        "actuator_gain_loss": "steady speed: an inertia asks for nothing there",
        "sensor_eccentricity": "one cycle a turn: an inertia has no fixed angle",
    },
    parameter_like=("inertia",),
)
