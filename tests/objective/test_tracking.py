"""Tracking error and command: closed forms, and what must not count."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.objective.metric_units import metric_unit, units_of_metrics
from gmfbo.objective.smoothing import smoothed
from gmfbo.objective.tracking import command_metrics, spent_energy, tracking_metrics

TIME = np.linspace(0.0, 10.0, 20001)


def test_itae_and_rms_of_a_decaying_error_are_the_closed_forms() -> None:
    rate = 3.0  # the integral of t exp(-a t) is 1 / a^2, that of exp(-2 a t) is 1 / (2 a)
    found = tracking_metrics(TIME, np.exp(-rate * TIME), begin=0.0, horizon=10.0)
    assert found["itae"] == pytest.approx(1.0 / rate**2, rel=1e-5)
    assert found["rms_error"] == pytest.approx(np.sqrt(1.0 / (2.0 * rate) / 10.0), rel=1e-5)


def test_a_broken_response_is_infinitely_bad_and_its_neighbour_is_not() -> None:
    errors = np.stack([np.ones(TIME.size), np.full(TIME.size, np.nan)])
    found = tracking_metrics(TIME, errors, begin=0.0, horizon=10.0)
    np.testing.assert_allclose(found["rms_error"], [1.0, np.inf])


def test_command_noise_is_the_deviation_of_white_noise_whatever_moves_slowly() -> None:
    noise = np.random.default_rng(0).normal(0.0, 0.3, TIME.size)
    slow = 40.0 * np.sin(2.0 * np.pi * 0.5 * TIME)
    found = command_metrics(TIME, slow + noise, begin=0.0, horizon=10.0)
    assert found["command_noise"] == pytest.approx(0.3, rel=0.02)
    assert found["rms_command"] == pytest.approx(40.0 / np.sqrt(2.0), rel=0.01)


def test_the_jump_that_a_step_asks_for_is_no_noise() -> None:
    command = np.where(TIME >= 2.0, 100.0, 0.0)
    part = {"begin": 0.0, "horizon": 10.0}
    assert command_metrics(TIME, command, jumps=[2.0], **part)["command_noise"] == 0.0
    # Control: a jump that nobody asked for is told.
    assert command_metrics(TIME, command, **part)["command_noise"] > 0.1


def test_work_taken_back_does_not_count() -> None:
    force, position = np.cos(TIME), np.sin(TIME)  # v = cos: power cos^2, never negative
    forward = spent_energy(TIME, force, position, begin=0.0, horizon=10.0)
    assert forward == pytest.approx(5.0 + np.sin(20.0) / 4.0, rel=1e-6)
    assert spent_energy(TIME, -force, position, begin=0.0, horizon=10.0) == pytest.approx(0.0)
    by_speed = spent_energy(TIME, force, force, begin=0.0, horizon=10.0, is_velocity=True)
    assert by_speed == pytest.approx(forward, rel=1e-6)


def test_units_follow_from_those_of_the_signals() -> None:
    units = units_of_metrics("rad", "N.m")
    assert (units["itae"], units["energy"], units["peak_command"]) == ("rad.s2", "J", "N.m")
    assert units_of_metrics("m", "V")["energy"] == "V.m"
    assert units_of_metrics("", "V")["energy"] == ""
    assert metric_unit("overshoot[2]") == "%"
    assert metric_unit("mine", units) == ""


@given(st.floats(1e-3, 5.0), st.integers(0, 1000))
def test_smoothing_keeps_mean_and_range(time_constant: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.5, 1.5, 200))
    values = rng.normal(size=(3, 200))
    found = smoothed(time, values, time_constant)
    gaps = np.diff(time)
    width = 0.5 * (np.append(gaps, 0.0) + np.append(0.0, gaps))
    np.testing.assert_allclose(found @ width, values @ width, atol=1e-9)
    assert found.max() <= values.max() + 1e-12
    assert found.min() >= values.min() - 1e-12


def test_smoothing_is_the_low_pass_in_both_directions_and_delays_nothing() -> None:
    omega, time_constant = 2.0 * np.pi, 0.1
    wave = np.sin(omega * TIME)
    inner = (TIME > 3.0) & (TIME < 7.0)
    gain = 1.0 / (1.0 + (omega * time_constant) ** 2)
    found = smoothed(TIME, wave, time_constant)
    np.testing.assert_allclose(found[inner], gain * wave[inner], atol=1e-5)
    np.testing.assert_array_equal(smoothed(TIME, wave, 0.0), wave)
