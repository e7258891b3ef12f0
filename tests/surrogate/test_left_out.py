"""Errors on left-out runs: the closed form against leaving out, and limits of the twin's worth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.correction.torch_setup import exact_algebra
from gmfbo.surrogate.corrected_twin import AxisRuns
from gmfbo.surrogate.left_out import errors_alone, errors_with_twin
from gmfbo.surrogate.model import SourceModel, SurrogateSettings
from gmfbo.surrogate.observations import Observations

TIME = np.linspace(0.0, 1.0, 40)


def axis(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(1.0 - np.exp(-(3.0 + 5.0 * points[:, :1]) * TIME) * np.cos(9.0 * TIME))


def cost(trajectories: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.mean((trajectories - 1.0) ** 2 * 20.0 * TIME, axis=-1))


def test_closed_form_is_what_leaving_out_gives() -> None:
    rng = np.random.default_rng(0)
    points = rng.random((8, 2))
    values = np.sin(4.0 * points[:, 0]) + points[:, 1]
    model = SourceModel.fit(Observations(points, ("IS1",) * 8, values), SurrogateSettings(ard=True))
    with exact_algebra():
        covariance = model.observed_covariance().detach().numpy()
    level = float(model.mean_module.constant.detach())
    standard = (values - values.mean()) / values.std(ddof=1) - level
    expected = []
    for row in range(8):
        rest = np.arange(8) != row
        weights = np.linalg.solve(covariance[np.ix_(rest, rest)], covariance[rest, row])
        expected.append((standard[row] - weights @ standard[rest]) * values.std(ddof=1))
    np.testing.assert_allclose(errors_alone(model), expected, rtol=1e-6, atol=1e-9)


def test_a_perfect_twin_makes_no_error() -> None:
    points = np.random.default_rng(1).random((6, 2))
    measured = axis(points)
    runs = AxisRuns(points, cost(measured), measured, measured)
    np.testing.assert_allclose(errors_with_twin(runs, cost), 0.0, atol=1e-12)


def test_the_run_that_is_predicted_is_not_looked_at() -> None:
    points = np.random.default_rng(2).random((5, 2))
    measured, simulated = axis(points), axis(0.5 * points)
    values = cost(measured)
    before = errors_with_twin(AxisRuns(points, values, simulated, measured), cost)
    moved, other = values.copy(), measured.copy()
    moved[3] += 7.0
    other[3] += 0.5
    after = errors_with_twin(AxisRuns(points, moved, simulated, other), cost)
    np.testing.assert_allclose(after[3] - before[3], 7.0, rtol=1e-12)


def test_failed_runs_have_no_error() -> None:
    points = np.random.default_rng(3).random((5, 2))
    measured = axis(points)
    values = cost(measured)
    simulated = measured.copy()
    simulated[2] = np.nan
    errors = errors_with_twin(AxisRuns(points, values, simulated, measured), priced)
    assert np.isnan(errors).tolist() == [False, False, True, False, False]


def priced(trajectories: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cost in which a failed run has a price."""
    return np.where(np.isfinite(trajectories).all(axis=-1), cost(trajectories), 9.0)
