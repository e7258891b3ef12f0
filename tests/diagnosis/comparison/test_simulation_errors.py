"""Errors of a simulation join the noise: exactly, and only where something is not linear."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.noise.unseen_rows import Mixing, UnseenRows
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, port_kernels
from gmfbo.diagnosis.comparison.row_fits import log_likelihood
from gmfbo.diagnosis.comparison.simulation_errors import SimulationErrors, errors_of
from gmfbo.diagnosis.comparison.whitener import SegmentWhitener, Whitening
from gmfbo.diagnosis.runs.scored_record import scored_record
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.short_recordings import SERVO

Array = NDArray[np.float64]
ROWS, LEVEL = 200, 3e-5  # [1], [rad] of the encoder


STRETCHES = [slice(0, 90), slice(90, ROWS)]


def white() -> SegmentWhitener:
    """Of two signals whose noise is white, of unit variance."""
    length = ROWS + 40
    plain = np.eye(2, dtype=complex)[None].repeat(length // 2 + 1, axis=0)
    nothing, unseen = np.zeros(ROWS), UnseenRows.of(plain, length, ROWS)
    return SegmentWhitener(
        (Mixing.by(plain),), nothing, np.zeros(ROWS, dtype=np.intp), length, unseen
    )


def test_the_density_beside_errors_is_that_of_the_dense_covariance() -> None:
    rng = np.random.default_rng(0)
    plain, stretches = white(), [slice(0, 60), slice(60, 120), slice(120, ROWS)]
    errors = 3.0 * rng.standard_normal((3, 2, ROWS))
    beside = plain.beside(errors, stretches)
    z = rng.standard_normal((2, ROWS)) + errors[0]
    told = float(np.sum(beside(z) ** 2) + beside.log_determinants.sum())
    seen, known = plain(z), plain(errors)  # nothing at the ends, where a filter sees beyond them
    exact = 0.0
    for rows in stretches:
        e, own = known[:, :, rows].reshape(3, -1), seen[:, rows].ravel()
        dense = np.eye(own.size) + e.T @ e
        exact += float(own @ np.linalg.solve(dense, own)) + float(np.linalg.slogdet(dense)[1])
    assert told == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("spread", [0.0, 0.3, 5.0])
def test_the_likelihood_of_a_row_is_that_of_the_dense_covariance_with_its_own_parts(
    spread: float,
) -> None:
    rng = np.random.default_rng(8)
    column, z = rng.standard_normal((2, 1, 2, ROWS))
    whitening = Whitening((white(),), {"inertia": spread})
    row = SimpleNamespace(
        residual=[z[0]], beside_own_parts=lambda w: w.about(["inertia"], [column])
    )
    own, seen = spread * white()(column)[0].ravel(), white()(z)[0].ravel()
    dense = np.eye(seen.size) + np.outer(own, own)
    exact = float(seen @ np.linalg.solve(dense, seen)) + float(np.linalg.slogdet(dense)[1])
    told = log_likelihood(cast(Any, row), whitening)
    assert told == pytest.approx(-0.5 * exact, rel=1e-10)


def test_no_columns_are_whitened_beside_errors_too() -> None:
    errors = np.random.default_rng(5).standard_normal((1, 2, ROWS))
    beside = white().beside(errors, STRETCHES)
    assert beside(np.zeros((0, 2, ROWS))).shape == (0, 2, ROWS)


def test_stretches_are_whitened_together_as_each_is_alone() -> None:
    rng = np.random.default_rng(6)
    errors, z = 2.0 * rng.standard_normal((2, 2, ROWS)), rng.standard_normal((3, 2, ROWS))
    uneven = [slice(0, 41), slice(41, 81), slice(81, 150), slice(150, ROWS)]
    together = white().beside(errors, uneven)
    alone = white()
    for rows in uneven:
        only = np.zeros_like(errors)
        only[:, :, rows] = errors[:, :, rows]
        alone = alone.beside(only, [slice(0, ROWS)])
    np.testing.assert_allclose(together(z), alone(z), atol=1e-12)


def test_errors_of_a_recording_and_of_its_stretches_add_to_the_dense_covariance() -> None:
    rng = np.random.default_rng(3)
    plain = white()
    constant, varying = 2.0 * rng.standard_normal((2, 1, 2, ROWS))
    whole = [slice(0, ROWS)]
    beside = plain.beside(constant, whole).beside(varying, STRETCHES)
    z = rng.standard_normal((2, ROWS)) + constant[0]
    told = float(np.sum(beside(z) ** 2) + beside.log_determinants.sum())
    seen, first, second = plain(z).ravel(), plain(constant).ravel(), plain(varying)
    dense = np.eye(seen.size) + np.outer(first, first)
    for rows in STRETCHES:
        own = np.zeros((2, ROWS))
        own[:, rows] = second[0][:, rows]
        dense += np.outer(own, own)
    exact = float(seen @ np.linalg.solve(dense, seen)) + float(np.linalg.slogdet(dense)[1])
    assert told == pytest.approx(exact, rel=1e-3)


def test_what_errors_made_of_a_residual_is_their_mean_given_it() -> None:
    rng = np.random.default_rng(1)
    plain = white()
    errors = 3.0 * rng.standard_normal((3, 2, ROWS))
    residual = rng.standard_normal((2, ROWS)) + 0.7 * errors[0] - 1.5 * errors[2]
    made = plain.mean_of(errors, residual)
    e, own = plain(errors).reshape(3, -1), plain(residual).ravel()
    dense = np.eye(own.size) + e.T @ e
    exact = np.tensordot(e @ np.linalg.solve(dense, own), errors, axes=1)
    np.testing.assert_allclose(made, exact, rtol=1e-9, atol=1e-12)


def test_only_a_noisier_stretch_counts_for_less() -> None:
    rng = np.random.default_rng(2)
    z = rng.standard_normal((2, ROWS))
    z[:, STRETCHES[0]] *= 3.0
    z[:, STRETCHES[1]] *= 0.1
    scaled = white().scaled_to(white()(z), STRETCHES)
    loud, still = (scaled(z)[:, rows] / z[:, rows] for rows in STRETCHES)
    inside = slice(30, 70)
    assert loud[:, inside] == pytest.approx(1.0 / 3.0, rel=0.15)
    assert still[:, inside] == pytest.approx(1.0)
    counted = np.count_nonzero(white()(z)[:, STRETCHES[0]])
    determinant = scaled.log_determinants[STRETCHES[0]].sum()
    assert determinant == pytest.approx(-2.0 * counted * np.log(loud[0, 40]))
    assert scaled.log_determinants[STRETCHES[1]].sum() == 0.0


@pytest.fixture(scope="module")
def axis() -> Iterator[Simulations]:
    """The servo axis at five substeps, and at ten as its half step."""
    twin = SERVO.twin()
    recordings = SERVO.recordings({}, seconds=0.8)[:1]

    def opened(substeps: int) -> Simulations:
        with AugmentedTwin(twin, substeps=substeps, isolated=False) as first:
            records = [
                scored_record(r, first.plan(r, {}), ["position", "torque_command"], 0.0)
                for r in recordings
            ]
        return Simulations(lambda: AugmentedTwin(twin, substeps=substeps), records, 1)

    with opened(5) as simulations:
        simulations.finer = lambda: opened(10)
        yield simulations


@pytest.fixture(scope="module")
def axis_at_two_gains() -> Iterator[Simulations]:
    """Two recordings of the servo axis, the second under half the gains."""
    twin = SERVO.twin()
    first, second = SERVO.recordings({}, seconds=0.8)[:2]
    gains = {name: 0.5 * value for name, value in first.parameters.items()}
    recordings = first, replace(second, parameters=gains)
    with AugmentedTwin(twin, substeps=5, isolated=False) as simulator:
        records = [
            scored_record(r, simulator.plan(r, {}), ["position", "torque_command"], 0.0)
            for r in recordings
        ]
    with Simulations(lambda: AugmentedTwin(twin, substeps=5), records, 1) as simulations:
        yield simulations


def kernels_of(axis: Simulations) -> PortKernels:
    return port_kernels(axis, Point(), {"sensor": 0.4}, "position", 1.0, "torque_command")


def measured(axis: Simulations, point: Point) -> tuple[SimulationErrors, PortKernels]:
    kernels = kernels_of(axis)
    return errors_of(axis, point, kernels, LEVEL), kernels


def test_a_linear_axis_has_no_error_but_that_of_its_step(axis: Simulations) -> None:
    errors, _ = measured(axis, Point())
    straight, *averaged = (np.std(column) for column in errors.constant[0][0])
    (step,) = (np.std(column) for column in errors.varying[0][0])
    assert step < LEVEL
    assert straight == 0.0  # the controller reads its reference at the rows
    assert len(averaged) == 2  # one a signal


def test_each_recording_answers_noise_under_its_own_gains(axis_at_two_gains: Simulations) -> None:
    errors, kernels = measured(axis_at_two_gains, Point())
    for own in errors.varying:  # nothing beyond the linear answer in either
        assert all(not len(columns) for columns in own)
    first, second = (kernels.of(k).kernels["sensor"]["torque_command"] for k in range(2))
    assert abs(second[0]) == pytest.approx(0.5 * abs(first[0]), rel=1e-3)


def test_friction_makes_of_noise_what_no_linear_path_makes(axis: Simulations) -> None:
    errors, _ = measured(axis, Point(physics={"coulomb_friction.level": 0.2}))
    step, *played = (np.std(column) for column in errors.varying[0][0])
    assert len(played) == 8
    assert min(played) > 0.01 * LEVEL
    assert step > 0.0


def test_a_logger_that_averages_is_late_by_the_mean_of_its_samples(axis: Simulations) -> None:
    errors, _ = measured(axis, Point())
    _, averaged, other = errors.constant[0][0]
    (run,) = axis.run([Point()])[0]
    speed = run.response.states["velocity"]
    late = 1e-3 * (5 - 1) / (2 * 5)  # [s] of five samples in a row of 1 ms
    assert averaged @ speed / (speed @ speed) == pytest.approx(-late, rel=0.01)
    assert not other.any()


def test_a_logger_that_is_slower_than_the_twin_averages_over_its_own_rows() -> None:
    """As a velocity that is the difference of two rows of counts does: half a row late."""
    twin, (whole, *_) = SERVO.twin(), SERVO.recordings({}, seconds=0.8)
    signals = {name: column[::10] for name, column in whole.signals.items()}
    rows = replace(whole, time=whole.time[::10], signals=signals)
    with AugmentedTwin(twin, substeps=5, isolated=False) as first:
        record = scored_record(rows, first.plan(rows, {}), ["position"], 0.0)
    with Simulations(lambda: AugmentedTwin(twin, substeps=5), [record], 1) as simulations:
        (run,) = simulations.run([Point()])[0]
        change = simulations.averaged(run, 0)[0] - run.signals[0]
        speed = record.plan.at(run.response.states["velocity"], record.signals[0].time)
    late = 1e-3 * (10 * 5 - 1) / (2 * 5)  # [s] of fifty samples in a row of 10 ms
    assert change @ speed / (speed @ speed) == pytest.approx(-late, rel=0.05)


def test_a_reference_drawn_straight_moves_a_loop_ahead_by_half_a_row(axis: Simulations) -> None:
    fast = Point({"sample_time": 0.2e-3})
    runs = axis.run([fast])[0]
    assert axis.unstated == {"reference"}  # the twin file does not say what inputs do
    (change,) = axis.input_errors(fast, runs)
    (same,) = axis.input_errors(Point(), axis.run([Point()])[0])
    axis.unstated = frozenset()
    try:
        assert axis.input_errors(fast, runs) == [None]
    finally:
        axis.unstated = frozenset({"reference"})
    assert change is not None
    assert same is not None
    assert not same[0].any()  # a controller that reads at the rows sees nothing between them
    position, speed = change[0], runs[0].response.states["velocity"]
    assert position @ speed / (speed @ speed) == pytest.approx(0.5e-3 * 4 / 5, rel=0.05)


def test_the_half_step_counts_as_simulations_and_follows_the_records(axis: Simulations) -> None:
    finer = axis.half_step
    assert finer is not None
    before = axis.runs
    finer.run([Point({"inertia": 0.0123})])
    assert axis.runs == before + 1
    assert [r.plan.substeps for r in finer.records] == [10]
    assert [[s.name for s in r.signals] for r in finer.records] == [
        [s.name for s in r.signals] for r in axis.records
    ]
