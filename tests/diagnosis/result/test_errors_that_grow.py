"""A signal is met worse where its error grows by more than a refit loses by chance."""

from __future__ import annotations

import pytest

from gmfbo.diagnosis.result.held_out_errors import SignalFit

NOTHING = float("nan")


@pytest.mark.parametrize(
    ("plain", "with_physics", "floor", "worse"),
    [
        (0.02, 0.08, 0.004, True),
        (0.02, 0.0203, 0.004, False),  # within a tenth of the noise
        (0.02, 0.0203, NOTHING, True),
        (0.02, 0.01, 0.004, False),
        (0.02, NOTHING, 0.004, False),  # nothing is named
    ],
)
def test_physics_meets_a_signal_worse_than_parameters_alone(
    plain: float, with_physics: float, floor: float, worse: bool
) -> None:
    assert SignalFit(0.1, plain, with_physics, NOTHING, floor).is_worse_with_physics is worse


def test_what_is_told_is_held_against_the_twin_that_came() -> None:
    assert SignalFit(0.02, 0.08, NOTHING, NOTHING, 0.004).is_worse
    assert not SignalFit(0.02, 0.08, 0.01, NOTHING, 0.004).is_worse
