"""Common parts of delays and lags."""

from __future__ import annotations

import math

import numpy as np

from gmfbo.physics.effect import EffectParameter, Range, Values
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, Mask, States

# Length of the memory for commands in physics.fmu, in time and in steps.
_MEMORY, _MEMORY_STEPS = 0.1, 2000  # [s]


def floor(excitation: Excitation) -> float:
    """Shortest time that is claimed [s]; a coarse integrator alone looks like 0.15 ms."""
    return max(0.4e-3, 0.35 * excitation.sample)


def longest_lag(excitation: Excitation) -> float:
    """Upper bound of a lag [s]."""
    return max(excitation.loop_time, 30.0 * floor(excitation))


def longest_delay(excitation: Excitation) -> float:
    """Upper bound of a delay [s]: the bound of a lag, within the memory of physics.fmu."""
    return min(_MEMORY, _MEMORY_STEPS * excitation.step, longest_lag(excitation))


def delay_too_coarse(excitation: Excitation) -> str | None:
    """Reason if no delay within the memory of physics.fmu is long enough to be claimed."""
    if 4.0 * floor(excitation) < longest_delay(excitation):
        return None
    return "the sampling is too coarse to show a delay"


def time_parameter(name: str, words: str, longest: Range = longest_lag) -> EffectParameter:
    """Make the parameter that holds a delay or a time constant, up to the longest."""
    return EffectParameter(
        name,
        words,
        "s",
        low=lambda e: 0.0,
        high=longest,
        scale=lambda e: min(2.0 * floor(e), 0.5 * longest(e)),
    )


def starts(name: str, excitation: Excitation, longest: Range = longest_lag) -> list[Values]:
    """Start values, about a factor of two apart, up to 0.6 of the longest [s].

    The response of a ringing loop is no smooth function of the delay: a fit that starts at half
    or twice the true delay stays there.
    """
    first, last = min(2.0 * floor(excitation), 0.5 * longest(excitation)), 0.6 * longest(excitation)
    count = 1 + max(round(math.log2(last / first)), 1)
    return [{name: float(time)} for time in np.geomspace(first, last, count)]


def delayed(times: Array, values: Array, delay: float) -> Array:
    """Values `delay` [s] earlier, with the first value held before; shape (n,)."""
    return np.interp(times - delay, times, values)


def lagged(times: Array, values: Array, time_constant: float) -> Array:
    """Values through a first-order lag that starts settled; shape (n,).

    Exact for values held over each step.
    """
    if time_constant <= 0.0:
        return values.copy()
    step = float(times[-1] - times[0]) / (len(times) - 1)
    keep = math.exp(-step / time_constant)
    result = np.empty_like(values)
    state = float(values[0])
    for index, value in enumerate(values.tolist()):
        result[index] = state
        state = keep * state + (1.0 - keep) * value
    return result


def lateness_feature(times: Array, values: Array) -> Array:
    """Change of a signal per second of lateness, shape (n,): minus its derivative."""
    return -np.asarray(np.gradient(values, times), dtype=np.float64)


def acts_in_fast_change(times: Array, values: Array) -> Mask:
    """Mark fast changes of a signal: above half of the quantile 0.95 of its rate."""
    rate = np.abs(np.gradient(values, times))
    return np.asarray(rate > 0.5 * np.quantile(rate, 0.95), dtype=np.bool_)


def command_acts(states: States, parameters: Values) -> Mask:
    """Samples with a fast command, at which lateness of the actuator shows."""
    return acts_in_fast_change(states.time, states.command)
