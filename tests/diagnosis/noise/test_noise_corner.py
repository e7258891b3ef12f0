"""A sharp filter keeps what is fast, and nothing of a line."""

from __future__ import annotations

import numpy as np

from gmfbo.diagnosis.noise.noise_corner import above

STEP = 1e-3


def test_a_filter_keeps_what_is_fast_and_nothing_of_a_line() -> None:
    time = STEP * np.arange(2000, dtype=np.float64)
    fast = np.sin(2.0 * np.pi * 200.0 * time)
    assert np.std(above(3.0 + 5.0 * time, STEP, 50.0)) < 1e-10
    # The ends of a wave do not join: there its slope jumps, which a sharp corner carries far.
    slow = above(np.sin(2.0 * np.pi * 10.0 * time), STEP, 50.0)
    assert np.abs(slow[200:-200]).max() < 5e-4
    np.testing.assert_allclose(above(fast, STEP, 50.0)[200:-200], fast[200:-200], atol=0.01)
