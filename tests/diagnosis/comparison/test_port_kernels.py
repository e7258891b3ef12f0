"""Answers to a push, and their frequency responses against the sum that defines them."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, port_kernels
from gmfbo.diagnosis.runs.scored_record import scored_record
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

STEP = 2e-3
COUNTS = 4096.0  # a turn of the drive's joint encoder


@pytest.mark.parametrize(
    "frequencies",
    [
        np.arange(251) / (500 * STEP),
        np.arange(60) / (1500 * STEP),
        np.arange(101) / (200 * STEP),
        np.arange(251) / (500 * STEP * (1.0 + 4e-6)),
        np.linspace(3.0, 40.0, 23),
    ],
    ids=["own rows", "rows three times as far apart", "fewer than taps", "another clock", "others"],
)
def test_a_response_is_the_fourier_sum_of_its_taps(frequencies: np.ndarray) -> None:
    taps = np.random.default_rng(1).standard_normal((2, 300))
    kernels = PortKernels({"torque": {"position": taps[0], "command": taps[1]}}, STEP)
    found = kernels.spectra("torque", ("position", "command"), frequencies)
    turn = np.exp(-2j * np.pi * np.outer(np.arange(300) * STEP, frequencies))
    np.testing.assert_allclose(found, taps @ turn, atol=1e-9)


def drive(counts: float) -> PortKernels:
    """Paths of the drive, whose encoder has so many counts a turn of the motor."""
    path = models_folder() / "drive_twin.toml"
    twin = FmuTwin(path, parameters={"enc.motor_resolution": counts}, isolated=False)
    time = 1e-3 * np.arange(600, dtype=np.float64)
    wave = 0.3 * np.sin(2.0 * np.pi * 2.0 * time)
    gains = {"ctl.Kp": 120.0, "ctl.Kd": 5.0}
    asked = Recording(time=time, signals={"reference": wave}, name="a.csv", parameters=gains)
    names = ["position", "torque_command"]
    run = twin.run({}, asked)
    signals = {"reference": wave, **{name: run.signal(name) for name in names}}
    recording = Recording(time=time, signals=signals, name="a.csv", parameters=gains)
    with AugmentedTwin(twin, substeps=5, isolated=False) as simulator:
        record = scored_record(recording, simulator.plan(recording, {}), names, 0.0)
    with Simulations(lambda: AugmentedTwin(twin, substeps=5), [record], 1) as simulations:
        return port_kernels(
            simulations, Point(), {"sensor": 0.6}, "position", 1.0, "torque_command"
        )


def test_a_coarse_encoder_answers_noise_as_a_fine_one() -> None:
    """One count of rounding, over a push of a hundredth of it, was 24 times the largest tap."""
    coarse, fine = (drive(n).kernels["sensor"]["torque_command"] for n in (4096.0, 2.0**24))
    assert np.abs(fine).max() > 1.0
    assert np.abs(coarse - fine).max() < 0.05 * np.abs(fine).max()


def test_rounding_of_the_twins_encoder_is_that_of_a_count_of_the_joint() -> None:
    assert drive(4096.0).rounding == pytest.approx(2.0 * np.pi / COUNTS / np.sqrt(12.0), rel=1e-6)


def test_noise_is_played_beyond_what_the_twin_rounds() -> None:
    kernels = PortKernels({}, STEP, rounding=3e-5)
    assert kernels.beyond_rounding(5e-5) == pytest.approx(4e-5)
    assert kernels.beyond_rounding(2e-5) == 0.0
    without = PortKernels({}, STEP, rounding=3e-5, is_counted=False)
    assert without.beyond_rounding(5e-5) == pytest.approx(5e-5)
