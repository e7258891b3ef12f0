"""Noise of the reading in a twin without a sensor port, against a twin that has one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from gmfbo import FmuTwin, Recording
from gmfbo.diagnosis.comparison.controller_reading import (
    controller_answer,
    controllers_of,
    with_reading,
)
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, Pushed, port_kernels
from gmfbo.diagnosis.runs.scored_record import scored_record
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.noise.planted_noise import servo_without_sensor

Array = NDArray[np.float64]
READING = "position", "torque_command", 1.0
GAINS = {"kp": 40.0, "kd": 0.6}, {"kp": 20.0, "kd": 0.4}


@contextmanager
def servo(path: Path, lag: float) -> Iterator[Simulations]:
    """The servo axis with a lag [s] of its current loop, in two recordings of other gains."""
    twin = FmuTwin(path, parameters={"torque_lag": lag}, isolated=False)
    time = twin.step * np.arange(1200, dtype=np.float64)
    reference = {"reference": 0.3 * np.sin(2.0 * np.pi * 2.0 * time)}
    names = ["position", "torque_command"]
    records = []
    for gains in GAINS:
        asked = Recording(time=time, signals=reference, name="a.csv", parameters=gains)
        run = twin.run({}, asked)
        signals = {**reference, **{name: run.signal(name) for name in names}}
        recording = Recording(time=time, signals=signals, name="a.csv", parameters=gains)
        with AugmentedTwin(twin, isolated=False) as simulator:
            records.append(scored_record(recording, simulator.plan(recording, {}), names, 0.0))
    with Simulations(lambda: AugmentedTwin(twin), records, 1) as simulations:
        yield simulations


def kernels_of(simulations: Simulations) -> PortKernels:
    sizes = {"sensor": 0.6, "torque": 5.0}
    return port_kernels(simulations, Point(), sizes, "position", 1.0, "torque_command")


def told(simulations: Simulations) -> PortKernels:
    kernels = kernels_of(simulations)
    controllers = controllers_of(kernels, *READING[:2], to_si=1.0)
    assert controllers is not None
    return with_reading(kernels, controllers, *READING)


@pytest.mark.parametrize(("lag", "off"), [(1e-5, 2e-3), (5e-4, 0.02)])
def test_paths_of_each_set_of_gains_are_those_of_the_port_but_for_a_lag_of_the_current_loop(
    tmp_path: Path, lag: float, off: float
) -> None:
    with servo(models_folder() / "servo_axis.toml", lag) as simulations:
        there = kernels_of(simulations)
    with servo(servo_without_sensor(tmp_path), lag) as simulations:
        found = told(simulations)
    assert there.controller is None
    for k in range(len(GAINS)):
        for name, kernel in there.of(k).kernels["sensor"].items():
            largest = np.abs(kernel).max()
            np.testing.assert_allclose(
                found.of(k).kernels["sensor"][name], kernel, atol=off * largest
            )
    one, other = (found.of(k).controller for k in range(len(GAINS)))
    assert one is not None
    assert other is not None
    assert not np.allclose(one, other)


def test_noise_played_as_torque_shakes_friction_loose_as_that_of_the_port_does(
    tmp_path: Path,
) -> None:
    noise = 3e-4 * np.random.default_rng(0).standard_normal(1200)
    rubbing = Point(physics={"coulomb_friction.level": 0.1})
    with servo(models_folder() / "servo_axis.toml", 1e-5) as simulations:
        still = simulations.run_one(rubbing, 0).response.states["position"]
        port = simulations.run_one(rubbing, 0, excitation={"sensor": noise})
        shaken = port.response.states["position"] - still
    with servo(servo_without_sensor(tmp_path), 1e-5) as simulations:
        played = told(simulations).of(0).sensed(noise)
        assert list(played) == ["torque"]
        torque = simulations.run_one(rubbing, 0, excitation=played)
        found = torque.response.states["position"] - still
    assert float(np.std(found - shaken)) < 0.05 * float(np.std(shaken))


@dataclass(frozen=True)
class Axis:
    """A rigid axis, held exactly from row to row, under a sampled controller."""

    step: float = 1e-3
    inertia: float = 0.01
    viscous: float = 0.02
    gear: float = 1.0  # torque on the axis per command
    integral: float = 0.0
    share_of_velocity: float = 0.0  # that is read and not made of the position

    def pushed(self) -> tuple[Array, Array]:
        """Position and command in the second after a push of one row."""
        rows = round(1.0 / self.step)
        rate = np.array([[0.0, 1.0], [0.0, -self.viscous / self.inertia]])
        force = np.array([[0.0], [1.0 / self.inertia]])
        whole = np.block([[rate, force], [np.zeros((1, 3))]])
        held = expm(self.step * whole)
        state, before, summed = np.zeros(2), 0.0, 0.0
        read, made = np.zeros(rows), np.zeros(rows)
        for k in range(rows):
            own = (state[0] - before) / self.step
            velocity = own + self.share_of_velocity * (state[1] - own)
            before, summed = state[0], summed + self.step * state[0]
            read[k] = state[0]
            made[k] = -(20.0 * state[0] + 0.5 * velocity + self.integral * summed) / self.gear
            state = held[:2, :2] @ state + held[:2, 2] * (self.gear * made[k] + (k == 0))
        return read, made


def answer(gear: float, integral: float, step: float) -> Array:
    rows = np.full(round(1.0 / step), -integral * step)
    rows[0] += -20.0 - 0.5 / step
    rows[1] += 0.5 / step
    return rows / gear


@pytest.mark.parametrize(
    "axis",
    [
        Axis(),
        Axis(viscous=0.0),
        Axis(step=2e-4, viscous=0.0),
        Axis(step=5e-3, inertia=0.05, viscous=0.5),
        Axis(gear=-100.0),
        Axis(integral=200.0),
    ],
    ids=["rigid", "without drag", "at 5 kHz", "at 200 Hz", "behind a gear", "integral"],
)
def test_a_sampled_controller_is_told_exactly_and_what_its_command_does(axis: Axis) -> None:
    read, made = axis.pushed()
    truth = answer(axis.gear, axis.integral, axis.step)
    found = controller_answer(read, made)
    assert found is not None
    near = min(900, found.size - 10)
    np.testing.assert_allclose(found[:near], truth[:near], atol=1e-5 * np.abs(truth).max())
    paths = {"torque": {"position": read, "torque_command": made}}
    kernels = PortKernels(paths, axis.step, paths, pushed=Pushed(read, made))
    controllers = controllers_of(kernels, *READING)
    assert controllers is not None
    np.testing.assert_allclose(controllers[-1].acting, axis.gear * found, rtol=0.01)


@pytest.mark.parametrize("viscous", [0.0, 0.5])
def test_a_controller_that_reads_a_velocity_of_its_own_is_not_told(viscous: float) -> None:
    """Noise of the position is not in that velocity, however well rows of the position tell it."""
    assert controller_answer(*Axis(viscous=viscous, share_of_velocity=1.0).pushed()) is None


def test_where_one_set_of_gains_is_not_told_none_is() -> None:
    read, made = Axis().pushed()
    paths = {"torque": {"position": read, "torque_command": made}}
    good = PortKernels(paths, 1e-3, paths, pushed=Pushed(read, made))
    away = PortKernels(paths, 1e-3, paths, pushed=Pushed(np.cumsum(read), made))
    assert controllers_of(good, *READING) is not None
    both = PortKernels(paths, 1e-3, paths, others={1: away}, pushed=Pushed(read, made))
    assert controllers_of(both, *READING) is None


def test_an_axis_that_does_not_answer_tells_nothing() -> None:
    read, made = Axis().pushed()
    assert controller_answer(0.0 * read, made) is None
    assert controller_answer(read, 0.0 * made) is None
