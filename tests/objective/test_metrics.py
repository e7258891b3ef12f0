"""Step metrics against python-control, closed forms and invariants."""

from __future__ import annotations

from collections.abc import Callable

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from gmfbo.errors import InputError
from gmfbo.objective.metrics import METRICS, step_metrics, worst_metrics


def second_order(time: ArrayLike, damping: float, frequency: float) -> NDArray[np.float64]:
    """Unit step response of w^2 / (s^2 + 2 z w s + w^2) from time 0, zero before."""
    damped = frequency * np.sqrt(1.0 - damping**2)
    t = np.maximum(np.asarray(time, dtype=float), 0.0)
    decay = np.exp(-damping * frequency * t)
    ratio = damping * frequency / damped
    return np.asarray(1.0 - decay * (np.cos(damped * t) + ratio * np.sin(damped * t)))


dampings = st.floats(0.15, 0.9)
frequencies = st.floats(15.0, 60.0)


@given(damping=dampings, frequency=frequencies)
@settings(max_examples=40, deadline=None)
def test_metrics_equal_python_control_within_one_sample(damping: float, frequency: float) -> None:
    sample_time = 1e-3
    time = np.arange(2001) * sample_time
    response = second_order(time, damping, frequency)
    info = control.step_info(response, T=time, yfinal=1.0)
    ours = step_metrics(time, response, step_time=0.0, horizon=2.0)
    assert ours["overshoot"] == pytest.approx(info["Overshoot"], abs=1e-9)
    assert abs(ours["rise_time"] - info["RiseTime"]) <= sample_time
    assert abs(ours["settling_time"] - info["SettlingTime"]) <= sample_time


@pytest.mark.parametrize("damping", [0.2, 0.5, 0.8])
def test_second_order_response_meets_the_closed_form(damping: float) -> None:
    frequency, horizon = 10.0, 5.0
    time = np.arange(500_001) * 1e-5
    ours = step_metrics(
        time, second_order(time, damping, frequency), step_time=0.0, horizon=horizon
    )

    def at(instant: float) -> float:
        return float(second_order(np.array([instant]), damping, frequency)[0])

    peak_time = np.pi / (frequency * np.sqrt(1.0 - damping**2))
    overshoot = 100.0 * np.exp(-np.pi * damping / np.sqrt(1.0 - damping**2))
    low, high = (brentq(lambda t, x=x: at(t) - x, 0.0, peak_time, xtol=1e-13) for x in (0.1, 0.9))
    # Between two extremes of the error there is one crossing of the band; the last extreme
    # outside the band begins the half wave in which the response settles.
    extremes = peak_time * np.arange(100)
    last = max(i for i, t in enumerate(extremes) if abs(at(t) - 1.0) > 0.02)
    settled = brentq(
        lambda t: abs(at(t) - 1.0) - 0.02,
        extremes[last],
        _next_zero(at, extremes[last], peak_time),
        xtol=1e-13,
    )
    assert ours["overshoot"] == pytest.approx(overshoot, abs=1e-6)
    assert ours["rise_time"] == pytest.approx(high - low, abs=1e-6)
    assert ours["settling_time"] == pytest.approx(settled, abs=1e-6)
    assert ours["transient_time"] == pytest.approx(settled, abs=1e-6)


def _next_zero(at: Callable[[float], float], start: float, half_wave: float) -> float:
    """Time after `start` at which the error crosses zero."""
    return float(brentq(lambda t: at(t) - 1.0, start, start + half_wave, xtol=1e-13))


responses = st.tuples(dampings, frequencies)


@given(parameters=responses, shift=st.floats(-5.0, 5.0), start=st.floats(0.0, 0.2))
@settings(max_examples=40, deadline=None)
def test_metrics_do_not_depend_on_when_the_step_comes(
    parameters: tuple[float, float], shift: float, start: float
) -> None:
    time = np.arange(1301) * 1e-3
    response = second_order(time - start, *parameters)
    here = step_metrics(time, response, step_time=start, horizon=1.0)
    there = step_metrics(time + shift, response, step_time=start + shift, horizon=1.0)
    for name in METRICS:
        assert there[name] == pytest.approx(here[name], abs=1e-9)


@given(
    parameters=responses,
    step_size=st.floats(-50.0, 50.0).filter(lambda value: abs(value) > 1e-3),
    initial=st.floats(-10.0, 10.0),
)
@settings(max_examples=40, deadline=None)
def test_metrics_do_not_depend_on_height_and_level_of_the_step(
    parameters: tuple[float, float], step_size: float, initial: float
) -> None:
    time = np.arange(1001) * 1e-3
    response = second_order(time, *parameters)
    unit = step_metrics(time, response, step_time=0.0, horizon=1.0)
    scaled = step_metrics(
        time,
        initial + step_size * response,
        step_time=0.0,
        step_size=step_size,
        initial=initial,
        horizon=1.0,
    )
    for name in METRICS:
        assert scaled[name] == pytest.approx(unit[name], abs=1e-7)


@given(st.lists(responses, min_size=1, max_size=6))
@settings(max_examples=25, deadline=None)
def test_a_batch_equals_a_loop(parameters: list[tuple[float, float]]) -> None:
    time = np.arange(801) * 1e-3
    batch = np.array([second_order(time, *p) for p in parameters])
    together = step_metrics(time, batch[:, None, :], step_time=0.0137, horizon=0.7)
    for row, response in enumerate(batch):
        alone = step_metrics(time, response, step_time=0.0137, horizon=0.7)
        for name in METRICS:
            assert together[name].shape == (len(parameters), 1)
            assert together[name][row, 0] == alone[name]


def test_times_are_interpolated_between_samples() -> None:
    # a ramp of slope 1 that stops at the reference: every crossing is known by hand
    time = np.arange(0.0, 2.01, 0.25)
    ours = step_metrics(time, np.minimum(time, 1.0), step_time=0.0, horizon=2.0)
    assert ours["rise_time"] == pytest.approx(0.8, abs=1e-12)
    assert ours["settling_time"] == pytest.approx(0.98, abs=1e-12)
    assert ours["transient_time"] == pytest.approx(0.98, abs=1e-12)
    assert ours["overshoot"] == 0.0


def test_a_steady_state_error_never_settles() -> None:
    time = np.arange(1001) * 1e-3
    ours = step_metrics(time, 0.95 * second_order(time, 0.8, 40.0), step_time=0.0, horizon=1.0)
    assert ours["settling_time"] == 1.0
    assert ours["rise_time"] < 0.1


def test_a_response_that_never_rises_gets_the_horizon() -> None:
    time = np.arange(101) * 1e-2
    ours = step_metrics(time, np.zeros(101), step_time=0.0, horizon=1.0)
    assert ours == {"overshoot": 0.0, "transient_time": 1.0, "rise_time": 1.0, "settling_time": 1.0}


def test_transient_time_is_measured_by_the_peak_error() -> None:
    # error 1 at the step, then -4, then 0.05: outside 2 % of the step, inside 2 % of the peak
    time = np.array([0.0, 1.0, 2.0, 3.0])
    ours = step_metrics(time, np.array([0.0, 5.0, 0.95, 0.95]), step_time=0.0, horizon=3.0)
    assert ours["settling_time"] == 3.0
    assert ours["transient_time"] == pytest.approx(1.0 + (4.0 - 0.08) / 4.05, abs=1e-12)


def test_a_response_at_the_reference_from_the_start_costs_no_time() -> None:
    ours = step_metrics(np.arange(11.0), np.ones(11), step_time=2.0, horizon=5.0)
    assert all(ours[name] == 0.0 for name in METRICS)


@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
def test_a_non_finite_response_gets_the_worst_case_and_leaves_its_neighbours(
    broken: float,
) -> None:
    time = np.arange(1001) * 1e-3
    response = np.array([second_order(time, 0.6, 30.0)] * 2)
    response[1, 700] = broken
    ours = step_metrics(time, response, step_time=0.0, horizon=1.0)
    assert {name: ours[name][1] for name in METRICS} == worst_metrics(1.0)
    assert ours["settling_time"][0] < 0.5


def test_samples_outside_the_horizon_do_not_count() -> None:
    time = np.arange(2001) * 1e-3
    response = second_order(time - 0.5, 0.6, 30.0)
    spoiled = response.copy()
    spoiled[time < 0.4999] = 77.0
    spoiled[time > 1.5001] = np.nan
    clean = step_metrics(time, response, step_time=0.5, horizon=1.0)
    assert step_metrics(time, spoiled, step_time=0.5, horizon=1.0) == clean


def test_a_short_recording_is_refused() -> None:
    with pytest.raises(InputError, match=r"samples from 0\.1 to 1\.1 s, got 0 to 1 s"):
        step_metrics(np.linspace(0, 1, 11), np.zeros(11), step_time=0.1, horizon=1.0)


def test_shapes_that_disagree_are_refused() -> None:
    with pytest.raises(InputError, match=r"got \(11,\) and \(2, 10\)"):
        step_metrics(np.linspace(0, 1, 11), np.zeros((2, 10)), step_time=0.0, horizon=1.0)


def test_a_step_of_zero_is_refused() -> None:
    with pytest.raises(InputError, match="a step other than zero"):
        step_metrics(np.arange(3.0), np.zeros(3), step_time=0.0, step_size=0.0, horizon=1.0)
