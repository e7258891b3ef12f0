"""Residuals and NRMSE against hand-made recordings."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.objective.fit import compare_at, nrmse
from gmfbo.recordings.recording import Recording, Trajectory

GRID = np.linspace(0.0, 1.0, 101)


def ramp(time: np.ndarray) -> np.ndarray:
    return np.asarray(2.0 * time + 1.0)


def test_a_straight_line_has_no_residual_between_samples() -> None:
    trajectory = Trajectory(time=GRID, signals={"x": ramp(GRID)})
    times = np.array([0.0, 0.013, 0.5, 0.777, 1.0])
    recording = Recording(time=times, signals={"x": ramp(times)})
    np.testing.assert_allclose(compare_at(trajectory, recording, "x"), 0.0, atol=1e-14)


def test_residual_is_recorded_minus_simulated_and_exact_on_the_grid() -> None:
    rng = np.random.default_rng(0)
    simulated, measured = rng.normal(size=(2, GRID.size))
    trajectory = Trajectory(time=GRID, signals={"x": simulated})
    recording = Recording(time=GRID, signals={"x": measured})
    np.testing.assert_array_equal(compare_at(trajectory, recording, "x"), measured - simulated)


def test_a_grid_that_differs_in_the_last_place_is_covered() -> None:
    summed = np.cumsum(np.full(101, 0.01)) - 0.01
    trajectory = Trajectory(time=GRID[:-1], signals={"x": GRID[:-1]})
    recording = Recording(time=summed[:-1], signals={"x": summed[:-1]})
    assert np.isfinite(compare_at(trajectory, recording, "x")).all()


def test_nrmse_is_rms_over_the_recorded_range() -> None:
    measured = np.sin(7.0 * GRID)
    trajectory = Trajectory(time=GRID, signals={"x": measured + 0.1})
    recording = Recording(time=GRID, signals={"x": measured})
    expected = 0.1 / np.ptp(measured)
    assert nrmse(trajectory, recording, "x") == pytest.approx(expected, rel=1e-12)


def test_rows_outside_use_and_warmup_are_not_scored() -> None:
    measured = np.sin(7.0 * GRID)
    simulated = measured + np.where((GRID >= 0.3) & (GRID <= 0.8), 0.0, 50.0)
    trajectory = Trajectory(time=GRID, signals={"x": simulated})
    used = Recording(time=GRID, signals={"x": measured}, use=(0.0, 0.8))
    assert nrmse(trajectory, used, "x", warmup=0.3) == 0.0
    assert nrmse(trajectory, used, "x") > 1.0


def test_unsampled_cells_are_not_scored() -> None:
    measured = np.where(np.arange(GRID.size) % 3 == 0, np.cos(GRID), np.nan)
    trajectory = Trajectory(time=GRID, signals={"x": np.cos(GRID)})
    assert nrmse(trajectory, Recording(time=GRID, signals={"x": measured}), "x") == 0.0


def test_a_simulation_that_stopped_is_not_scored_as_if_whole() -> None:
    trajectory = Trajectory(
        time=GRID[:50], signals={"x": GRID[:50]}, status="diverged", stopped_at=0.5
    )
    recording = Recording(time=GRID, signals={"x": GRID}, name="rec.csv")
    assert np.isnan(compare_at(trajectory, recording, "x")[50:]).all()
    with pytest.raises(RecordingError, match=r"'x' is not simulated.*diverged at 0\.5 s"):
        nrmse(trajectory, recording, "x")


def test_a_short_simulation_says_what_it_covers() -> None:
    trajectory = Recording(time=GRID[:50], signals={"x": GRID[:50]})
    with pytest.raises(RecordingError, match=r"it covers 0 to 0\.49 s"):
        nrmse(trajectory, Recording(time=GRID, signals={"x": GRID}), "x")


def test_a_simulation_of_nan_only_leaves_nothing_compared() -> None:
    trajectory = Recording(time=GRID, signals={"x": np.full(GRID.size, np.nan)})
    recording = Recording(time=GRID, signals={"x": GRID})
    assert np.isnan(compare_at(trajectory, recording, "x")).all()


def test_a_constant_signal_has_no_range() -> None:
    recording = Recording(time=GRID, signals={"x": np.ones(GRID.size)})
    with pytest.raises(RecordingError, match="'x' is constant"):
        nrmse(recording, recording, "x")


def test_nothing_to_score_is_refused() -> None:
    recording = Recording(time=GRID, signals={"x": GRID})
    with pytest.raises(RecordingError, match="no row of 'x' to score"):
        nrmse(recording, recording, "x", warmup=9.0)
