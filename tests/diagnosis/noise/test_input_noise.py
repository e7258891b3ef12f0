"""The fast part of a recorded input counts as noise only as far as the recordings show it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import BENCH, Reference, open_small

Array = NDArray[np.float64]

FAST = 0.3
"""[A] Of a current of 1.5 A."""


def shaken(seed: int, size: float) -> list[Recording]:
    """Two recordings of the bench under a current whose fast part the axis got."""
    rng = np.random.default_rng(seed)

    def current(phase: float) -> Reference:
        def values(time: Array) -> Array:
            slow = 1.5 * np.sin(3.0 * np.pi * time + phase)
            return np.asarray(slow + size * rng.standard_normal(time.size))

        return values

    return BENCH.recordings({}, (current(0.0), current(1.0)))


def beyond_noise(recordings: list[Recording]) -> float:
    """chi2 of the right twin over what its budget expects of noise."""
    case = open_small(BENCH.twin(), recordings)
    try:
        return case.base.chi2 / float(sum(case.budget.noise_squares))
    finally:
        case.simulations.close()


@pytest.mark.parametrize("size", [0.0, FAST])
def test_what_the_axis_got_is_no_noise(size: float) -> None:
    """With all of it sent as noise, less than half of the budget was used."""
    assert 0.8 < beyond_noise(shaken(1, size)) < 1.2


def test_what_only_the_record_holds_is_noise() -> None:
    """Negative control: without it in the budget, the right twin would leave far more."""
    rng = np.random.default_rng(2)
    recorded = [
        r.with_signals({"current": r.signal("current") + FAST * rng.standard_normal(r.time.size)})
        for r in shaken(1, 0.0)
    ]
    assert 0.6 < beyond_noise(recorded) < 1.4
