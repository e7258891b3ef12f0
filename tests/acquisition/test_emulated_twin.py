"""The search on an emulated twin: near a dense oracle, repeatable, within what is allowed."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.acquisition.emulated_twin import emulate, expected_best, next_axis_run
from gmfbo.acquisition.improvement import log_improvement
from gmfbo.acquisition.maximise import Search
from gmfbo.correction.residual_process import ResidualProcess
from gmfbo.errors import InputError
from gmfbo.surrogate.corrected_twin import AxisRuns, CorrectedTwinModel

TIME = np.linspace(0.0, 1.0, 60)


def axis(points: NDArray[np.float64]) -> NDArray[np.float64]:
    rate = 3.0 + 5.0 * points[:, :1]
    return np.asarray(1.0 - np.exp(-rate * TIME) * np.cos(9.0 * points[:, 1:] * TIME))


def twin(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return axis(np.column_stack([0.8 * points[:, 0], points[:, 1]]))


def cost(trajectories: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.mean((trajectories - 1.0) ** 2 * 20.0 * TIME, axis=-1))


@pytest.fixture(scope="module")
def emulator() -> ResidualProcess:
    survey = np.random.default_rng(0).random((150, 2))
    return emulate(survey, twin(survey))


@pytest.fixture(scope="module")
def model() -> CorrectedTwinModel:
    points = np.random.default_rng(1).random((5, 2))
    measured = axis(points)
    return CorrectedTwinModel.fit(AxisRuns(points, cost(measured), twin(points), measured), cost)


def test_emulator_is_the_twin_between_its_runs(emulator: ResidualProcess) -> None:
    points = np.random.default_rng(2).uniform(0.05, 0.95, (100, 2))
    error = emulator.mean(points) - twin(points)
    assert np.sqrt(np.mean(error**2)) < 0.01 * np.ptp(twin(points))


def test_proposal_is_near_the_best_of_a_dense_grid(
    model: CorrectedTwinModel, emulator: ResidualProcess
) -> None:
    side = np.linspace(0.0, 1.0, 151)
    dense = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    mean, variance = model.predict(dense, emulator.mean(dense))
    oracle = log_improvement(mean, variance, float(model.runs.values.min()))
    _, value = next_axis_run(model, emulator, Search(2), np.random.default_rng(3))
    assert value > oracle.max() - 0.05
    _, least = expected_best(model, emulator, Search(2), np.random.default_rng(3))
    assert least < mean.min() + 0.01 * np.ptp(mean)


def test_a_few_runs_reach_the_optimum_of_the_axis(emulator: ResidualProcess) -> None:
    side = np.linspace(0.0, 1.0, 101)
    truth = cost(axis(np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)))
    points = np.random.default_rng(4).random((2, 2))
    rng = np.random.default_rng(5)
    for _ in range(8):
        measured = axis(points)
        runs = AxisRuns(points, cost(measured), twin(points), measured)
        fitted = CorrectedTwinModel.fit(runs, cost)
        point, _ = next_axis_run(fitted, emulator, Search(2), rng)
        points = np.vstack([points, point])
    best = cost(axis(points)).min()
    assert best <= truth.min() + 0.02 * (np.median(truth) - truth.min())


def test_same_generator_gives_the_same_proposal(
    model: CorrectedTwinModel, emulator: ResidualProcess
) -> None:
    first, second = (
        next_axis_run(model, emulator, Search(2), np.random.default_rng(6)) for _ in range(2)
    )
    np.testing.assert_array_equal(first[0], second[0])


def test_fixed_and_snapped_gains_are_respected(
    model: CorrectedTwinModel, emulator: ResidualProcess
) -> None:
    search = Search(2, fixed={1: 0.25}, snap=lambda points: np.round(points * 20.0) / 20.0)
    point, _ = next_axis_run(model, emulator, search, np.random.default_rng(7))
    assert point[1] == 0.25
    assert point[0] * 20.0 == pytest.approx(round(point[0] * 20.0))


def test_exhausted_raster_is_an_error_and_not_a_repeat(emulator: ResidualProcess) -> None:
    corners = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    runs = AxisRuns(corners, cost(axis(corners)), twin(corners), axis(corners))
    model = CorrectedTwinModel.fit(runs, cost)
    with pytest.raises(InputError, match="all candidate gains were run already by IS1"):
        next_axis_run(model, emulator, Search(2, snap=np.round), np.random.default_rng(8))
