"""How far the corrected twin may be off, over the box and at each place of it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.surrogate.trust import LOCAL_LENGTHSCALE, TrustOf, local_trust, uniform_trust

POINTS = np.array([[0.1, 0.1], [0.15, 0.2], [0.9, 0.9], [0.85, 0.8]])
BOX = np.random.default_rng(0).random((50, 2))


@pytest.mark.parametrize("trust_of", [uniform_trust, local_trust])
def test_without_a_left_out_run_the_spread_of_the_costs_is_believed(trust_of: TrustOf) -> None:
    trust = trust_of(np.empty((0, 2)), np.empty(0), 3.0, 0.1)
    assert trust(BOX).tolist() == [3.0] * len(BOX)


@pytest.mark.parametrize("trust_of", [uniform_trust, local_trust])
def test_no_trust_is_boundless(trust_of: TrustOf) -> None:
    assert trust_of(POINTS, np.zeros(4), 3.0, 0.1)(BOX).tolist() == [0.1] * len(BOX)


def test_equal_errors_make_both_the_same() -> None:
    errors = np.array([2.0, -2.0, 2.0, -2.0])
    local = local_trust(POINTS, errors, 5.0, 0.1)(BOX)
    assert local == pytest.approx(uniform_trust(POINTS, errors, 5.0, 0.1)(BOX))


def test_a_bad_place_is_trusted_less_than_a_good_one() -> None:
    errors: NDArray[np.float64] = np.array([4.0, -5.0, 0.1, 0.1])
    bad, good = local_trust(POINTS, errors, 5.0, 0.01)(POINTS[[0, 2]])
    assert bad > 1.5 * good
    far = np.array([[20.0 * LOCAL_LENGTHSCALE, 0.0]])
    everywhere = uniform_trust(POINTS, errors, 5.0, 0.01)(far)
    assert local_trust(POINTS, errors, 5.0, 0.01)(far) == pytest.approx(everywhere)
