"""Thermal derating: the actuator weakens as it warms up."""

import math

import numpy as np

from gmfbo.physics.effect import Effect, EffectParameter, Units, Values
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, Mask, States
from gmfbo.physics.timing import lagged
from gmfbo.units import percent, quantity

# Effective current of a typical motion, as a share of its largest.
_EFFECTIVE = 0.5


def _warmth(states: States, parameters: Values) -> Array:
    """Heat since the start, shape (n,): 1 is settled at the current `scale`."""
    scale = parameters.get("scale") or _EFFECTIVE * float(np.max(np.abs(states.current)))
    heating = (states.current / max(scale, np.finfo(float).tiny)) ** 2
    # A lag starts settled on its first value; before that first value there was no heat.
    step = states.step
    times = np.concatenate(([states.time[0] - step], states.time))
    return lagged(times, np.concatenate(([0.0], heating)), parameters["time"])[1:]


def _signal(states: States, parameters: Values) -> Array:
    gain = np.maximum(0.0, 1.0 - parameters["loss"] * _warmth(states, parameters))
    return np.asarray((gain - 1.0) * states.command, dtype=np.float64)


def _feature(states: States) -> Array:
    duration = float(states.time[-1] - states.time[0])
    return -_warmth(states, {"time": 0.5 * duration}) * states.command


def _not_excited(excitation: Excitation) -> str | None:
    if excitation.duration < 20.0 * excitation.loop_time:
        return "no recording is long enough to warm up"
    return None


def _acts(states: States, parameters: Values) -> Mask:
    warmth = _warmth(states, parameters)
    return np.asarray(warmth > 0.5 * np.max(warmth), dtype=np.bool_)


def _statement(parameters: Values, units: Units, place: str) -> str:
    # Where recordings are short beside the time constant, they show no more than the first rate.
    rate = percent(parameters["loss"] / parameters["time"])
    return (
        f"The actuator weakens as it warms up, by about {rate} a second at first, with a time "
        f"constant of {quantity(parameters['time'], 's')}, which is missing from the twin."
    )


thermal_derating = Effect(
    name="thermal_derating",
    port="command",
    family="gain",
    signal_path="actuator",
    parameters=(
        EffectParameter(
            "loss",
            "Loss when warm",
            "1",
            low=lambda e: 0.0,
            high=lambda e: 2.0,
            scale=lambda e: 0.1,
        ),
        EffectParameter(
            "time",
            "Thermal time constant",
            "s",
            low=lambda e: 0.03 * e.duration,
            high=lambda e: 30.0 * e.duration,
            scale=lambda e: 0.3 * e.duration,
        ),
    ),
    fixed=lambda e: {"scale": e.effective_current or _EFFECTIVE * e.current},
    starts=lambda e: [{"loss": 0.02, "time": share * e.duration} for share in (0.15, 1.2)],
    size=lambda p, e: p["loss"] * -math.expm1(-e.duration / p["time"]),
    size_name="loss",
    size_unit="1",
    floor=lambda e: 1e-3,
    not_excited=_not_excited,
    signal=_signal,
    feature=_feature,
    acts=_acts,
    region=lambda p, units: "late in time, once the actuator is warm",
    region_state="time",
    statement=_statement,
    equation="u_out = (1 - loss * x) * u, T * dx/dt = (i / i_0)^2 - x",
    source="Mellor, Roberts and Turner, 1991",
    confused_with={
        "actuator_gain_loss": "early and late: a gain does not change with time",
        "actuator_saturation": "early peaks, which derating passes",
        "magnetic_saturation": "early peaks, which derating passes",
    },
)
