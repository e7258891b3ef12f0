"""Intervals follow a valley of the likelihood that bends."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis, Setting
from gmfbo.diagnosis.fitting.intervals import Spread
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.fitting.profile_intervals import widened_by_profile
from tests.physics.excitations import TYPICAL

Array = NDArray[np.float64]

FRICTION = Candidate("presliding_friction", {"level": 1.0, "deflection": 0.004})
"""Two parameters of one effect; what they show is given by the test."""

HYPOTHESIS = Hypothesis(Setting((), TYPICAL), (FRICTION,))
BEST = HYPOTHESIS.start({})
ALIKE, APART = 0.01, 0.4  # deviations of what both show together, and of one alone
BENT, STRAIGHT = 1.0, 0.0


@dataclass
class Shown:
    """A misfit whose residual is known in closed form, of the parameters over their best values.

    The first falls as the second rises, along a line or along a parabola.
    """

    bend: float

    def residual_at(self, x: Array) -> tuple[Array, ...]:
        level, deflection = x / BEST - 1.0
        together = deflection + level - self.bend * level**2
        return (np.array([-together / ALIKE, -level / APART]),)

    @property
    def simulations(self) -> SimpleNamespace:
        def run(points: list[object]) -> list[list[SimpleNamespace]]:
            return [[SimpleNamespace(finite=True, point=point)] for point in points]

        return SimpleNamespace(run=run)

    def residual(self, simulated: list[SimpleNamespace]) -> tuple[Array, ...]:
        physics = simulated[0].point.physics
        return self.residual_at(
            np.array([physics[f"presliding_friction.{n}"] for n in ("level", "deflection")])
        )

    @property
    def fitted(self) -> Fitted:
        columns = -np.array(
            [
                (self.residual_at(BEST + step)[0] - self.residual_at(BEST - step)[0])
                / (2.0 * step.sum())
                for step in 1e-6 * np.diag(BEST)
            ]
        )
        return Fitted(HYPOTHESIS, BEST, [], self.residual_at(BEST), (columns,), [])

    def rise(self, level: float) -> float:
        """Least chi2 over the deflection at one level: the oracle."""

        def square(deflection: float) -> float:
            return float(np.sum(self.residual_at(np.array([level, deflection]))[0] ** 2))

        found = minimize_scalar(square, bounds=(0.0, 3.0 * BEST[1]), method="bounded")
        return float(found.fun)

    def widened(self, half: float) -> Spread:
        off = half * BEST
        normal = Spread(off / 1.96, BEST - off, BEST + off)
        return widened_by_profile(cast(Misfit, self), self.fitted, normal, [0])


@pytest.mark.parametrize("bend", [STRAIGHT, BENT])
def test_an_interval_that_is_too_narrow_ends_where_the_likelihood_has_fallen(bend: float) -> None:
    shown = Shown(bend)
    spread = shown.widened(0.4)
    for end in (spread.low[0], spread.high[0]):
        assert shown.rise(end) == pytest.approx(3.84, rel=0.1)
    assert spread.low[1] == pytest.approx(0.6 * BEST[1])  # that was not asked for


def test_an_interval_is_never_narrowed() -> None:
    spread = Shown(BENT).widened(2.0)
    assert (spread.low[0], spread.high[0]) == (-BEST[0], 3.0 * BEST[0])


def test_a_narrow_interval_is_left_alone() -> None:
    spread = Shown(BENT).widened(0.1)
    np.testing.assert_allclose([spread.low[0], spread.high[0]], BEST[0] * np.array([0.9, 1.1]))
