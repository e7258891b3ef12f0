"""Errors of a simulation join the noise: exactly, and only where something is not linear."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.port_kernels import PortKernels, port_kernels
from gmfbo.diagnosis.comparison.simulation_errors import SimulationErrors, errors_of
from gmfbo.diagnosis.comparison.whitener import SegmentWhitener
from gmfbo.diagnosis.runs.scored_record import scored_record
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.short_recordings import SERVO

Array = NDArray[np.float64]
ROWS, LEVEL = 200, 3e-5  # [1], [rad] of the encoder


def test_the_density_beside_errors_is_that_of_the_dense_covariance() -> None:
    rng = np.random.default_rng(0)
    plain = SegmentWhitener(
        (np.eye(2, dtype=complex)[None].repeat(ROWS // 2 + 1, axis=0),),
        np.zeros(ROWS),
        np.zeros(ROWS, dtype=np.intp),
        ROWS,
    )
    errors = 3.0 * rng.standard_normal((3, 2, ROWS))
    stretches = [slice(0, 90), slice(90, ROWS)]
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


def kernels_of(axis: Simulations) -> PortKernels:
    return port_kernels(axis, Point(), {"sensor": 0.4}, "position", 1.0, "torque_command")


def measured(axis: Simulations, point: Point) -> tuple[SimulationErrors, PortKernels]:
    kernels = kernels_of(axis)
    runs = axis.run([point])[0]
    return errors_of(axis, point, runs, kernels, LEVEL), kernels


def test_a_linear_axis_has_no_error_but_that_of_its_step(axis: Simulations) -> None:
    errors, _ = measured(axis, Point())
    (step,) = (np.std(column) for column in errors.columns[0][0])
    assert step < LEVEL


def test_friction_makes_of_noise_what_no_linear_path_makes(axis: Simulations) -> None:
    errors, _ = measured(axis, Point(physics={"coulomb_friction.level": 0.2}))
    step, *played = (np.std(column) for column in errors.columns[0][0])
    assert len(played) == 8
    assert min(played) > 0.01 * LEVEL
    assert step > 0.0


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
