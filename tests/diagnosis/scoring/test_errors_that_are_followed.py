"""Errors of the position that a plant in open loop is kept near: its loop follows most of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.scoring.nuisances import POSITION_SCALE, nuisance_directions
from tests.diagnosis.short_recordings import BENCH, moves, multisine, open_small


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
        simulations.tracking = tracking
        directions = nuisance_directions(
            simulations, point, case.base.simulated, case.rig.alignments, 1.0
        )
        for (_, (direction,), *_), base, run in zip(
            directions, case.base.simulated, followed, strict=True
        ):
            whole = POSITION_SCALE * base.signals[0]
            left = whole - (run.signals[0] - base.signals[0])
            assert np.linalg.norm(direction - left) < 0.02 * np.linalg.norm(left)
            assert np.linalg.norm(whole - left) > 5.0 * np.linalg.norm(left)
