"""How bent responses are: smooth ones, and noise."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.diagnosis.fitting.difference_steps import bent_shares


def square(blocks: object) -> float:
    return float(sum(np.sum(np.asarray(own) ** 2) for own in blocks))  # type: ignore[attr-defined]


def test_a_parabola_is_bent_by_its_curvature_and_noise_by_three() -> None:
    rng = np.random.default_rng(0)
    curve = [[np.full(10, s + 0.5 * s**2)] for s in (0.0, 0.1, 0.2)]
    noise = [[rng.standard_normal(100_000)] for _ in range(2)]
    found = bent_shares([curve[0], curve[1], curve[2]], square)
    assert found[0] == pytest.approx((0.01 / 0.105) ** 2)
    noisy = bent_shares([[rng.standard_normal(100_000)], *noise], square)
    assert noisy[0] == pytest.approx(3.0, rel=0.02)


def test_what_cannot_be_simulated_is_not_told() -> None:
    assert bent_shares([[np.zeros(3)], None, [np.ones(3)]], square) == [None]
