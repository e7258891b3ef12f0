"""Impulse responses of a port, against closed forms and against the FMU itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo import FmuTwin
from gmfbo.diagnosis.screening.impulse_response import impulse_responses, random_binary, sampling
from gmfbo.diagnosis.screening.port_response import between_points, measure_port_response
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.port_cases import GAINS, SERVO, PortCase, open_servo, opened, port_case

BENCH = models_folder() / "motor_bench.toml"


@pytest.fixture
def servo(right_servo: PortCase) -> PortCase:
    return right_servo


def test_a_known_kernel_comes_back_from_a_random_binary_signal() -> None:
    kernel = np.exp(-np.arange(400) / 25.0) * np.cos(np.arange(400) / 9.0)
    column = random_binary(3000, np.random.default_rng(1))
    answer = np.convolve(column, kernel)[: column.size]
    found = impulse_responses(column, {"y": answer}, 1e-3)["y"]
    np.testing.assert_allclose(found, kernel[: found.size], atol=1e-5)
    assert found.size > 100


def test_kernels_of_one_excitation_are_as_long_as_the_slowest() -> None:
    column = random_binary(2000, np.random.default_rng(2))
    slow = np.convolve(column, 0.97 ** np.arange(500))[: column.size]
    found = impulse_responses(column, {"fast": column, "slow": slow}, 1e-3)
    assert found["fast"].size == found["slow"].size > 200


def test_a_random_binary_signal_is_silent_first_and_then_only_switches() -> None:
    column = random_binary(500, np.random.default_rng(0))
    assert column[0] == 0.0
    assert set(column[1:]) == {-1.0, 1.0}


@given(st.floats(0.0, 3.0), st.floats(0.3, 4.0), st.integers(0, 2**31))
def test_spreading_is_the_transpose_of_reading(offset: float, ratio: float, seed: int) -> None:
    grid = np.linspace(0.0, 0.049, 50)
    time: NDArray[np.float64] = 1e-3 * np.arange(offset, 49.0, ratio, dtype=np.float64)
    samples = sampling(grid, time)
    rng = np.random.default_rng(seed)
    column, values = rng.standard_normal(50), rng.standard_normal(time.size)
    there = float(values @ samples.read(column))
    assert there == pytest.approx(float(samples.spread(values, 50) @ column), abs=1e-9)


def test_samples_between_points_are_read_linearly() -> None:
    samples = sampling(np.arange(5.0), np.array([0.0, 1.5, 3.25, 4.0]))
    np.testing.assert_allclose(samples.read(np.arange(5.0) ** 2), [0.0, 2.5, 10.75, 16.0])


def test_a_state_between_points_is_the_mean_of_both_ends() -> None:
    np.testing.assert_allclose(between_points(np.array([0.0, 2.0, 6.0])), [1.0, 4.0, 6.0])


def test_a_lasting_torque_is_held_by_the_proportional_gain(servo: PortCase) -> None:
    static = servo.response.gains(0, np.zeros(1))[0].real
    np.testing.assert_allclose(static, [1.0 / GAINS["kp"], -1.0], rtol=2e-3)


def test_recordings_under_the_same_parameters_share_one_response(servo: PortCase) -> None:
    first, *others = servo.response.kernels
    assert all(kernel is own for other in others for kernel, own in zip(first, other, strict=True))


def test_the_fmu_under_a_torque_moves_as_its_response_says(servo: PortCase) -> None:
    case, record = servo.case, 1
    time = case.simulations.records[record].plan.grid
    torque = 0.2 * np.sin(2.0 * np.pi * 3.0 * time) * (time > 0.5) + 0.1 * (time > 1.2)
    point = case.base.hypothesis.point(case.base.x)
    run = case.simulations.run_one(point, record, excitation={"torque": torque})
    said = servo.response.filtered(record, torque)
    for after, before, change in zip(
        run.signals, case.base.simulated[record].signals, said, strict=True
    ):
        scale = float(np.abs(after - before).max())
        np.testing.assert_allclose(change, after - before, atol=1e-3 * scale)


def test_several_columns_are_filtered_as_each_alone(servo: PortCase) -> None:
    columns = np.random.default_rng(3).standard_normal((3, servo.response.rows[0]))
    together = servo.response.filtered(0, columns)
    for i, column in enumerate(columns):
        for many, one in zip(together, servo.response.filtered(0, column), strict=True):
            np.testing.assert_allclose(many[i], one, atol=1e-12)


def test_backwards_is_the_transpose_of_filtered(servo: PortCase) -> None:
    rng = np.random.default_rng(4)
    column = rng.standard_normal(servo.response.rows[2])
    answers = servo.response.filtered(2, column)
    signals = [rng.standard_normal(answer.size) for answer in answers]
    there = sum(float(a @ b) for a, b in zip(answers, signals, strict=True))
    assert float(servo.response.backwards(2, signals) @ column) == pytest.approx(there, rel=1e-9)


def test_a_twin_without_the_port_has_no_response(tmp_path: Path) -> None:
    text = SERVO.read_text().replace('"servo_axis.fmu"', f'"{SERVO.with_suffix(".fmu")}"')
    path = tmp_path / "servo.toml"
    path.write_text(text.replace('torque = "tau_load"', ""))
    case = open_servo({}, FmuTwin(path))
    assert measure_port_response(case, "torque", np.random.default_rng(0)) is None
    case.simulations.close()


def test_an_open_plant_that_is_kept_near_its_recording_answers_a_torque() -> None:
    case = opened(FmuTwin(BENCH), [_bench_recording()])
    assert case.simulations.tracking is not None
    response = port_case(case).response
    static = response.gains(0, np.zeros(1))[0].real
    stiffness = case.simulations.tracking.settings["tracking.kp"]
    np.testing.assert_allclose(static, [1.0 / stiffness], rtol=5e-2)
    case.simulations.close()


def _bench_recording() -> Recording:
    time: NDArray[np.float64] = 1e-3 * np.arange(2000, dtype=np.float64)
    current = 2.0 * np.sin(2.0 * np.pi * 2.0 * time)
    with AugmentedTwin(FmuTwin(BENCH), substeps=10) as simulator:
        alone = Recording(time=time, signals={"current": current}, name="bench.csv")
        run = simulator.run(simulator.plan(alone, {}), {})
    noise = 1e-5 * np.random.default_rng(6).standard_normal(time.size)
    signals = {"current": current, "position": run.held["position"] + noise}
    return Recording(time=time, signals=signals, name="bench.csv", written_by="test")
