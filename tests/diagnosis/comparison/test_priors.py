"""Priors integrate to one, and their slopes and curvatures belong to them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from gmfbo.diagnosis.comparison.priors import Prior

CAUCHY = Prior(-50.0, 50.0, False, "cauchy", 0.0, 0.5)
HALF = Prior(0.0, 200.0, False, "cauchy", 0.0, 0.5)
UNIFORM = Prior(1e-3, 1e2, True, "uniform", 0.0, 0.0)
NORMAL = Prior(1e-3, 1e3, True, "normal", 0.0, 0.4)


@pytest.mark.parametrize("prior", [CAUCHY, HALF, UNIFORM, NORMAL])
def test_the_density_integrates_to_one(prior: Prior) -> None:
    low, high = prior.bounds
    total, _ = quad(
        lambda u: np.exp(prior.log_density(u)), low, high, points=[prior.centre], limit=400
    )
    assert total == pytest.approx(1.0, abs=0.01)


@given(st.floats(-3.0, 3.0))
def test_the_slope_is_the_derivative_and_the_parabola_lies_above(u: float) -> None:
    for prior in (CAUCHY, NORMAL):
        step = 1e-6
        rise = prior.log_density(u - step) - prior.log_density(u + step)
        assert prior.slope(u) == pytest.approx(rise / (2.0 * step), abs=1e-5)
        for away in (-2.0, -0.3, 0.3, 2.0):
            parabola = prior.slope(u) * away + 0.5 * prior.curvature(u) * away**2
            moved = prior.log_density(u) - prior.log_density(u + away)
            assert moved <= parabola + 1e-9


@given(st.floats(1.1e-3, 0.9e2))
def test_a_value_comes_back_from_its_coordinate(value: float) -> None:
    assert UNIFORM.to_value(UNIFORM.to_u(value)) == pytest.approx(value)
