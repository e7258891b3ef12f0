"""Neighbourhoods of unsafe runs are left out, unless the axis was safe nearer by."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.tuning.history.keep_out import KEEP_OUT_RADIUS, KeepOut

UNSAFE = np.array([[0.5, 0.5]])


def test_without_unsafe_runs_everything_is_allowed() -> None:
    assert KeepOut().admits(np.array([[0.5, 0.5]])).all()


def test_points_beside_an_unsafe_run_are_kept_out() -> None:
    keep_out = KeepOut(UNSAFE)
    near, far = np.array([0.55, 0.5]), np.array([0.5 + 2 * KEEP_OUT_RADIUS, 0.5])
    assert keep_out.admits(np.stack([near, far])).tolist() == [False, True]


def test_a_nearer_safe_run_of_the_axis_allows_again() -> None:
    point = np.array([[0.56, 0.5]])
    assert not KeepOut(UNSAFE).admits(point)[0]
    assert KeepOut(UNSAFE, np.array([[0.6, 0.5]])).admits(point)[0]


def test_a_box_that_is_unsafe_all_over_leaves_its_farthest_points() -> None:
    corners = np.array([[0.0, 0.0], [0.0, 0.1], [0.1, 0.0], [0.1, 0.1]])
    candidates = np.array([[0.02, 0.02], [0.05, 0.05], [0.09, 0.03]])
    keep_out = KeepOut(corners)
    assert not keep_out.admits(candidates).any()
    assert keep_out.admitted(candidates).tolist() == [False, True, False]


@given(st.integers(0, 1000), st.integers(1, 5), st.integers(1, 30))
def test_a_proposal_is_moved_to_where_it_is_allowed(seed: int, d: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    keep_out, point = KeepOut(rng.random((count, d)) * 0.5), rng.random(d) * 0.5
    moved = keep_out.nearest_admitted(point, {})
    assert keep_out.admits(moved[None, :])[0]
    if keep_out.admits(point[None, :])[0]:
        np.testing.assert_array_equal(moved, point)


def test_held_gains_stay_held_when_a_proposal_is_moved() -> None:
    moved = KeepOut(UNSAFE).nearest_admitted(np.array([0.5, 0.5]), {1: 0.5})
    assert moved[1] == 0.5
    assert abs(moved[0] - 0.5) > KEEP_OUT_RADIUS
