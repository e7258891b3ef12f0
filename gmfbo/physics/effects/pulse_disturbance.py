"""A passing disturbance: a push or a cut that starts and ends."""

import numpy as np

from gmfbo.physics.effect import Effect, EffectParameter, Units, Values, signed
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, States
from gmfbo.units import number, quantity


def _signal(states: States, parameters: Values) -> Array:
    """Level times the share of each step [t, t + h] that the pulse covers."""
    step = states.step
    begin = np.maximum(states.time, parameters["start"])
    end = np.minimum(states.time + step, parameters["start"] + parameters["duration"])
    return np.asarray(parameters["level"] * np.clip(end - begin, 0.0, step) / step)


def _starts(excitation: Excitation) -> list[Values]:
    whole = excitation.duration
    pulses = excitation.pulses[:4] or ((0.4 * whole, 0.1 * whole),)
    inside = (0.001 * whole, 0.999 * whole)
    return [
        {
            "start": min(max(start, inside[0]), inside[1]),
            "duration": min(max(lasting, 2.0 * _shortest(excitation)), inside[1]),
            "level": 0.1 * excitation.torque,
        }
        for start, lasting in pulses
    ]


def _shortest(excitation: Excitation) -> float:
    return min(excitation.sample, 0.1 * excitation.duration)


def _region(parameters: Values, units: Units) -> str:
    start = parameters["start"]
    end = start + parameters["duration"]
    return f"in the time from {number(start)} s to {number(end)} s"


def _statement(parameters: Values, units: Units, place: str) -> str:
    size = quantity(parameters["level"], units.torque)
    lasting = quantity(parameters["duration"], "s")
    start = number(parameters["start"])
    return (
        f"A passing {units.torque_word} of about {size} {place}, {lasting} long from {start} s on, "
        "is missing from the twin."
    )


pulse_disturbance = Effect(
    name="pulse_disturbance",
    port="torque",
    family="disturbance",
    signal_path="plant",
    parameters=(
        signed("level", "Level", "torque", lambda e: e.torque, most=2.0),
        EffectParameter(
            "start",
            "Start",
            "s",
            low=lambda e: 1e-6 * e.duration,
            high=lambda e: e.duration,
            scale=lambda e: 0.02 * e.duration,
        ),
        EffectParameter(
            "duration",
            "Duration",
            "s",
            low=_shortest,
            high=lambda e: e.duration,
            scale=lambda e: 0.02 * e.duration,
        ),
    ),
    starts=_starts,
    size=lambda p, e: abs(p["level"]),
    size_name="level",
    size_unit="torque",
    floor=lambda e: 3e-4 * e.torque,
    signal=_signal,
    acts=lambda states, p: _signal(states, {**p, "level": 1.0}) > 0.0,
    region=_region,
    region_state="time",
    statement=_statement,
    equation="tau = tau_0 for t_0 <= t < t_0 + T",
    source="Heaviside, 1893",
    confused_with={
        "constant_torque_offset": "a longer recording: a pulse ends",
        "coulomb_friction": "the same motion again: a passing push does not return",
    },
)
