"""Ranges that the recordings contradict are told from physics that is missing."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import pytest

from gmfbo.diagnosis.case.wider_ranges import wider_ranges
from tests.diagnosis.short_recordings import SERVO, moves, multisine, open_small, triangle

REFERENCES = (multisine, moves, triangle)


@pytest.mark.parametrize(
    ("truth", "beyond"),
    [
        ({"inertia": 0.055, "viscous": 0.3}, {"inertia", "viscous"}),
        ({"inertia": 0.0105, "viscous": 0.32}, {"viscous"}),
        ({"inertia": 0.002, "viscous": 0.05}, {"inertia"}),
        ({"inertia": 0.0011, "viscous": 0.05}, {"inertia"}),  # further off than to zero
    ],
)
def test_values_beyond_their_ranges_are_found(truth: dict[str, float], beyond: set[str]) -> None:
    axis = replace(SERVO, truth=truth)
    with closing((case := open_small(axis.twin(), axis.recordings({}, REFERENCES))).simulations):
        found = wider_ranges(case)
    assert found is not None
    assert set(found.ranges) == beyond
    assert found.values == pytest.approx(truth, rel=0.05)
    for name, (low, high) in found.ranges.items():
        assert 0.0 <= low < truth[name] < high


def test_control_within_the_ranges_nothing_is_tried() -> None:
    with closing((case := open_small(SERVO.twin(), SERVO.recordings({}))).simulations):
        runs = case.simulations.runs
        assert wider_ranges(case) is None
        assert case.simulations.runs == runs


@pytest.mark.parametrize(
    "physics",
    [
        {"coulomb_friction.level": 0.6},
        {"constant_torque_offset.level": 0.8},
        {"transport_delay.delay": 0.004},
    ],
)
def test_control_physics_is_not_taken_for_a_range_that_is_too_narrow(
    physics: dict[str, float],
) -> None:
    made = SERVO.recordings(physics, REFERENCES)
    with closing((case := open_small(SERVO.twin(), made)).simulations):
        assert wider_ranges(case) is None
