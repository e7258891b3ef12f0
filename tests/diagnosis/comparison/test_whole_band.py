"""Noise of the logger that the controller's noise hides at high frequencies is no torque."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.noise.high_band import estimated
from gmfbo.diagnosis.comparison.noise.places import Levels, blocks_of
from gmfbo.diagnosis.comparison.noise.whole_band import _Binned, _Shares, inadequate
from gmfbo.diagnosis.comparison.numbers import TORQUE_TIME
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.comparison.segments import Segment

STEP, ROWS, TAPS = 1e-3, 4000, 400
NAMES = ("position", "command")
KP, KD, INERTIA = 40.0, 0.8, 0.01
CARED = {"torque": 1e-5}


def answers(pushed: str) -> dict[str, NDArray[np.float64]]:
    """Impulse responses of a rotor under a proportional and derivative controller."""
    q = v = last = 0.0
    found = {name: np.zeros(TAPS) for name in NAMES}
    for k in range(TAPS):
        read = q + (1.0 if pushed == "sensor" and k == 0 else 0.0)
        command = -KP * read - KD * (read - last) / STEP
        last = read
        found["position"][k] = read
        found["command"][k] = command
        torque = command + (1.0 if pushed == "torque" and k == 0 else 0.0)
        v += STEP * torque / INERTIA
        q += STEP * v
    return found


KERNELS = PortKernels({port: answers(port) for port in ("sensor", "torque")}, STEP)


def coloured(rng: np.random.Generator, time: float = TORQUE_TIME) -> NDArray[np.float64]:
    """Torque noise of unit variance with a correlation time."""
    keep = np.exp(-STEP / time)
    found = np.zeros(ROWS)
    for k in range(1, ROWS):
        found[k] = keep * found[k - 1] + np.sqrt(1.0 - keep**2) * rng.standard_normal()
    return found


def driven(
    rng: np.random.Generator, pushed: NDArray[np.float64], command: float
) -> NDArray[np.float64]:
    """Signals under noise of the reading, a torque, and noise of the logger."""
    read = 4e-5 * rng.standard_normal(ROWS)
    paths = KERNELS.kernels
    signals = [
        np.convolve(read, paths["sensor"][name])[:ROWS]
        + np.convolve(pushed, paths["torque"][name])[:ROWS]
        for name in NAMES
    ]
    signals[0] = signals[0] + 2e-6 * rng.standard_normal(ROWS)
    signals[1] = signals[1] + command * rng.standard_normal(ROWS)
    return np.stack(signals)


@pytest.mark.parametrize(("torque", "command"), [(0.0, 8e-3), (2e-2, 1e-3)])
def test_hidden_white_noise_and_a_torque_are_told_apart(torque: float, command: float) -> None:
    rng = np.random.default_rng(2)
    time = np.linspace(0.0, STEP * (ROWS - 1), ROWS)
    own = [Segment(k, NAMES, time, (time, time)) for k in range(3)]
    residuals = [driven(rng, torque * coloured(rng), command) for _ in own]
    still = [np.zeros((2, ROWS)) for _ in own]
    least = Levels({"sensor": 1e-9}, {"position": 1e-7, "command": 5e-5})
    free = ["port:sensor", "own:position", "own:command"]
    top = estimated(KERNELS, blocks_of(own, residuals, still, KERNELS), least, free)
    for near in (None, top.with_ports(torque=1e-3)):
        found = inadequate(KERNELS, own, residuals, still, top, CARED, near)
        assert found.ports["sensor"] == pytest.approx(4e-5, rel=0.05)
        if torque:
            assert found.ports["torque"] == pytest.approx(torque, rel=0.15)
        else:
            assert found.ports["torque"] < 1e-3  # an eighth of the noise that hides
            assert found.own["command"] == pytest.approx(command, rel=0.1)


def after_saturation(rng: np.random.Generator, torque: float) -> NDArray[np.float64]:
    """Signals under a torque that a loop sends on but for its command's second half."""
    pushed = torque * coloured(rng)
    paths = KERNELS.kernels["torque"]
    position, command = (np.convolve(pushed, paths[name])[:ROWS] for name in NAMES)
    command[ROWS // 2 :] = 0.0
    own = [2e-6 * rng.standard_normal(ROWS), 1e-3 * rng.standard_normal(ROWS)]
    return np.stack([position, command]) + np.stack(own)


@pytest.mark.parametrize("torque", [2e-3, 2e-2])
def test_where_a_command_saturates_the_torque_that_is_missing_is_not_exaggerated(
    torque: float,
) -> None:
    rng = np.random.default_rng(3)
    time = np.linspace(0.0, STEP * (ROWS - 1), ROWS)
    own = [Segment(k, NAMES, time, (time, time)) for k in range(3)]
    residuals = [after_saturation(rng, torque) for _ in own]
    still = [np.zeros((2, ROWS)) for _ in own]
    levels = Levels({"sensor": 1e-9}, {"position": 2e-6, "command": 1e-3})
    least = replace(levels.with_ports(**CARED), astray={"torque": 1e-7})
    loud = replace(levels.with_ports(torque=0.3), astray={"torque": 0.3})
    for near in (None, least, loud):
        found = inadequate(KERNELS, own, residuals, still, levels, CARED, near)
        assert 0.5 * torque < found.ports["torque"] < 1.1 * torque
        assert 0.1 * torque < found.astray["torque"] < 1.1 * torque
        assert found.own["position"] < 2e-5


def test_of_a_command_that_answers_nothing_most_is_astray() -> None:
    """From any start: the rotor's position moves, its controller's command does not."""
    rng = np.random.default_rng(4)
    time = np.linspace(0.0, STEP * (ROWS - 1), ROWS)
    own = [Segment(k, NAMES, time, (time, time)) for k in range(3)]
    residuals = [after_saturation(rng, 2e-2) for _ in own]
    for signals in residuals:
        signals[1] = 1e-3 * rng.standard_normal(ROWS)
    still = [np.zeros((2, ROWS)) for _ in own]
    levels = Levels({"sensor": 1e-9}, {"position": 2e-6, "command": 1e-3})
    least = replace(levels.with_ports(**CARED), astray={"torque": 1e-7})
    for near in (None, least):
        found = inadequate(KERNELS, own, residuals, still, levels, CARED, near)
        assert found.astray["torque"] > 5.0 * found.ports["torque"]
        assert found.own["position"] < 2e-5


def test_deviances_of_many_levels_are_those_of_each() -> None:
    rng = np.random.default_rng(3)
    made = rng.standard_normal((4, 5, 2, 2)) + 1j * rng.standard_normal((4, 5, 2, 2))
    whole = made @ made.conj().swapaxes(-1, -2)
    binned = _Binned(NAMES, np.arange(5.0), np.arange(1.0, 6.0), whole[0], np.zeros(2), 0)
    shares = _Shares(binned, whole[1], whole[2:])
    levels = rng.uniform(0.1, 3.0, (6, 2))
    each = [shares.deviance(one)[0] for one in levels]
    np.testing.assert_allclose(shares.deviances(levels), each, rtol=1e-12)


def test_what_an_encoder_in_the_twin_rounds_is_no_less_where_nothing_is_left() -> None:
    time = np.linspace(0.0, STEP * (ROWS - 1), ROWS)
    own = [Segment(0, NAMES, time, (time, time))]
    quiet = [np.zeros((2, ROWS))]
    top = Levels({"sensor": 2e-5}, {"position": 1e-7, "command": 5e-5})
    found = inadequate(KERNELS, own, quiet, quiet, top, {**CARED, "sensor": 2e-5})
    assert found.ports["sensor"] == pytest.approx(2e-5)
    without = inadequate(KERNELS, own, quiet, quiet, top, CARED)
    assert without.ports["sensor"] < 1e-6


@pytest.mark.parametrize("time", [5e-3, 2e-2, 8e-2])
def test_the_time_of_torque_noise_is_found(time: float) -> None:
    rng = np.random.default_rng(4)
    clock = np.linspace(0.0, STEP * (ROWS - 1), ROWS)
    own = [Segment(k, NAMES, clock, (clock, clock)) for k in range(4)]
    residuals = [driven(rng, 0.1 * coloured(rng, time), 1e-3) for _ in own]
    still = [np.zeros((2, ROWS)) for _ in own]
    levels = Levels({"sensor": 4e-5}, {"position": 2e-6, "command": 1e-3})
    found = inadequate(KERNELS, own, residuals, still, levels, CARED)
    assert found.time == pytest.approx(time)
