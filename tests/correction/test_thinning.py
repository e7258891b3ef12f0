"""Which samples are kept of a trajectory."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.correction.thinning import thin


@given(rows=st.integers(2, 400), count=st.integers(2, 120), seed=st.integers(0, 99))
def test_indices_increase_stay_within_and_hold_both_ends(rows: int, count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.5, 1.5, rows))
    kept = thin(time, rng.standard_normal(rows), rng.standard_normal(rows), count)
    assert np.all(np.diff(kept) > 0)
    assert kept[0] == 0
    assert kept[-1] == rows - 1
    assert len(kept) <= max(count, min(rows, count))


def test_samples_are_denser_where_the_response_moves() -> None:
    time = np.asarray(np.arange(1101) * 1e-3, dtype=np.float64)
    simulated = np.where(time > 0.1, 1.0 - np.exp(-(time - 0.1) / 0.03), 0.0)
    kept = time[thin(time, simulated, 0.95 * simulated, 300)]
    moving = np.sum((kept > 0.1) & (kept < 0.25)) / 0.15
    resting = np.sum(kept > 0.5) / 0.6
    assert moving > 4.0 * resting
    assert np.diff(kept).max() < 0.02


def test_steps_of_a_quantised_sensor_are_not_taken_for_change() -> None:
    time = np.asarray(np.arange(1000) * 1e-3, dtype=np.float64)
    ramp = 0.05 * time
    counts = np.round(ramp * 600.0) / 600.0
    kept = thin(time, ramp, counts, 100)
    assert np.diff(time[kept]).max() < 0.05


def test_short_trajectories_are_kept_whole() -> None:
    time = np.arange(10.0)
    np.testing.assert_array_equal(thin(time, time, time, 10), np.arange(10))
