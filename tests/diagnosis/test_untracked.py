"""Errors of the position that a plant in open loop is kept near: its loop follows most of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.nuisances import POSITION_SCALE, record_directions
from gmfbo.diagnosis.untracked import TRACKING_RAD_S, left_by_tracking
from tests.diagnosis.short_recordings import BENCH, moves, multisine, open_small

Array = NDArray[np.float64]


def test_the_loop_leaves_the_second_integral_of_a_constant_force() -> None:
    """s^2 / (s^2 + 2 d w s + w^2) of t^2 / 2 ends at 1 / w^2."""
    time: Array = np.arange(4000) * 1e-3
    left = left_by_tracking(0.5 * time**2, 1e-3)
    assert left[-1] == pytest.approx(1.0 / TRACKING_RAD_S**2, rel=1e-3)


def test_the_direction_of_an_encoders_scale_is_what_a_scaled_recording_leaves() -> None:
    """Simulated with recording and loop scaled; the whole position is far from it."""
    case = open_small(BENCH.twin(), BENCH.recordings({}, (multisine, moves)))
    with case.simulations as simulations:
        tracking = simulations.tracking
        assert tracking is not None
        point = case.base.hypothesis.point(case.base.x)
        scaled = tuple((1.0 + POSITION_SCALE) * column for column in tracking.measured)
        simulations.tracking = replace(tracking, measured=scaled)
        followed = simulations.run([point])[0]
        for record, base, run in zip(
            simulations.records, case.base.simulated, followed, strict=True
        ):
            _, direction, _ = record_directions(record, base, case.rig.alignments)
            whole = POSITION_SCALE * base.signals[0]
            left = whole - (run.signals[0] - base.signals[0])
            # The plant's own friction, which the filter does not know, is what is amiss.
            assert np.linalg.norm(direction[0] - left) < 0.5 * np.linalg.norm(left)
            assert np.linalg.norm(whole - left) > 5.0 * np.linalg.norm(left)
