"""Late error: whether a run settled, under noise, counts and unstable loops."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.objective.settled import error_growth, late_error, run_noise

TIME = np.arange(0.0, 1.1005, 1e-3)
STEP = {"step_time": 0.1, "target": 1.0, "step_size": 1.0, "horizon": 1.0, "band": 0.02}


def response(damping: float, omega: float = 40.0) -> NDArray[np.float64]:
    """Step response of a second-order loop; it grows for negative damping."""
    since = np.maximum(TIME - 0.1, 0.0)
    wave = np.cos(omega * since) * np.exp(-damping * omega * since)
    return np.where(TIME < 0.1, 0.0, 1.0 - wave)


def test_the_late_error_is_the_largest_error_of_the_last_tenth_over_the_band() -> None:
    offset = np.where(TIME < 0.1, 0.0, 1.01)
    assert late_error(TIME, offset, **STEP) == pytest.approx(0.5)
    assert late_error(TIME, np.where(TIME > 0.99, 1.2, offset), **STEP) == pytest.approx(10.0)
    assert late_error(TIME, np.where(TIME < 0.95, 1.2, offset), **STEP) == pytest.approx(0.5)


@pytest.mark.parametrize(("damping", "settles"), [(0.3, True), (0.0, False), (-0.05, False)])
def test_a_swinging_loop_does_not_settle(damping: float, settles: bool) -> None:
    assert bool(late_error(TIME, response(damping), **STEP) <= 1.0) is settles


def test_noise_beyond_the_band_is_excused_and_an_oscillation_as_large_is_not() -> None:
    rng = np.random.default_rng(0)
    noise = 0.012 * rng.standard_normal((200, TIME.size))
    noisy = response(0.3) + noise
    assert np.all(late_error(TIME, noisy, **STEP) <= 1.0)
    assert np.all(np.abs(noisy[:, -100:] - 1.0).max(axis=1) > 0.02)
    # As large in the mean square, but not there before the step.
    ringing = response(0.3) + np.where(TIME < 0.1, 0.0, 0.1 * np.sin(600.0 * TIME))
    assert late_error(TIME, ringing, **STEP) > 1.0


def test_noise_never_excuses_a_tenth_of_the_step() -> None:
    rng = np.random.default_rng(1)
    noisy = np.where(TIME < 0.1, 0.0, 1.15) + 0.1 * rng.standard_normal(TIME.size)
    assert late_error(TIME, noisy, **STEP) > 1.0


def test_two_counts_of_a_coarse_sensor_are_excused() -> None:
    count = 0.0125
    rounded = count * np.round(response(0.3) / count)
    assert late_error(TIME, rounded + 1.9 * count * (TIME > 0.99), **STEP) <= 1.0
    assert late_error(TIME, rounded + 2.9 * count * (TIME > 0.99), **STEP) > 1.0


def test_a_response_that_is_not_finite_has_an_infinite_late_error() -> None:
    broken = response(0.3)
    broken[-1] = np.nan
    assert np.isinf(late_error(TIME, broken, **STEP))


@given(scale=st.floats(1e-6, 1e6), offset=st.floats(-1e3, 1e3), sign=st.sampled_from([-1.0, 1.0]))
def test_the_unit_of_the_signal_does_not_matter(scale: float, offset: float, sign: float) -> None:
    plain = float(late_error(TIME, response(0.02), **STEP))
    moved = {**STEP, "target": scale * (offset + sign), "step_size": sign * scale}
    found = late_error(TIME, scale * (offset + sign * response(0.02)), **moved)
    assert found == pytest.approx(plain, rel=1e-6)


def test_the_noise_is_that_at_rest() -> None:
    rng = np.random.default_rng(2)
    noisy = response(0.3) + 0.01 * rng.standard_normal(TIME.size)
    assert run_noise(TIME, noisy, 0.1, 1.0) == pytest.approx(0.01, rel=0.35)
    assert run_noise(TIME, response(0.0), 0.1, 1.0) == 0.0


def test_a_tracking_error_that_grows_is_told_from_one_that_stays() -> None:
    steady = 0.2 * np.sin(20.0 * TIME)
    assert error_growth(TIME, steady) <= 1.0
    assert error_growth(TIME, steady * np.exp(2.0 * TIME)) > 1.0
    assert error_growth(TIME, np.zeros(TIME.size)) == 0.0
