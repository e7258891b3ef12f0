"""What acted before a recording and after it: exactly, and in a loop that remembers."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.fft import irfft, rfft
from scipy.linalg import toeplitz

from gmfbo.diagnosis.comparison.noise.high_band import estimated
from gmfbo.diagnosis.comparison.noise.places import Levels, blocks_of
from gmfbo.diagnosis.comparison.noise.unseen_rows import UnseenRows
from gmfbo.diagnosis.comparison.noise.whole_band import inadequate
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, through
from gmfbo.diagnosis.comparison.segments import Segment
from gmfbo.diagnosis.comparison.whitener import UNMASKED, segment_whitener

Array = NDArray[np.float64]
STEP, ROWS, TAPS = 1e-3, 3000, 2000
NAMES = ("command", "position")
KP, KI, KD, INERTIA = 20.0, 90.0, 0.6, 0.005
TORQUE, TIME, SENSOR, COMMAND = 0.05, 0.04, 4e-5, 0.01


@pytest.mark.parametrize("length", [24, 25])
def test_unseen_rows_are_the_conditional_mean_of_the_dense_covariance(length: int) -> None:
    rng, seen = np.random.default_rng(0), 17
    made = rng.standard_normal((2, 2, length)) * np.exp(-0.5 * np.arange(length))
    paths = rfft(made, axis=-1).transpose(2, 0, 1)
    spectra = paths @ paths.conj().swapaxes(1, 2) + 0.1 * np.eye(2)
    lagged = irfft(spectra, length, axis=0)
    dense = np.block(
        [
            [toeplitz(lagged[:, i, j], np.roll(lagged[::-1, i, j], 1)) for j in range(2)]
            for i in range(2)
        ]
    )
    known = np.concatenate([np.arange(seen), length + np.arange(seen)])
    others = np.setdiff1d(np.arange(2 * length), known)
    columns = rng.standard_normal((3, 2, seen))
    exact = dense[np.ix_(others, known)] @ np.linalg.solve(
        dense[np.ix_(known, known)], columns.reshape(3, -1).T
    )
    told = irfft(
        UnseenRows.of(spectra.astype(np.complex128), length, seen).whole(columns), length, axis=-1
    )
    np.testing.assert_allclose(told[..., :seen], columns, atol=1e-12)
    np.testing.assert_allclose(told[..., seen:].reshape(3, -1), exact.T, atol=1e-10)


def answers(pushed: str) -> dict[str, Array]:
    """Impulse responses of a rotor under a controller with an integrator."""
    q = v = last = total = 0.0
    found = {name: np.zeros(TAPS) for name in NAMES}
    for k in range(TAPS):
        read = q + (1.0 if pushed == "sensor" and k == 0 else 0.0)
        command = -KP * read - KD * (read - last) / STEP - KI * total
        total, last = total + STEP * read, read
        found["position"][k], found["command"][k] = read, command
        torque = command + (1.0 if pushed == "torque" and k == 0 else 0.0)
        v += STEP * torque / INERTIA
        q += STEP * v
    return found


KERNELS = PortKernels({port: answers(port) for port in ("sensor", "torque")}, STEP)


def driven(rng: np.random.Generator) -> Array:
    """Signals of a loop that a torque moved long before it was recorded."""
    before = 2 * TAPS
    keep, pushed = np.exp(-STEP / TIME), np.zeros(before + ROWS)
    for k in range(1, pushed.size):
        pushed[k] = keep * pushed[k - 1] + TORQUE * np.sqrt(1.0 - keep**2) * rng.standard_normal()
    read = SENSOR * rng.standard_normal(pushed.size)
    paths = KERNELS.kernels
    signals = [
        through(read, paths["sensor"][name]) + through(pushed, paths["torque"][name])
        for name in NAMES
    ]
    found = np.stack(signals)[:, before:]
    found[0] += COMMAND * rng.standard_normal(ROWS)
    found[1] += 1e-7 * rng.standard_normal(ROWS)
    return found


def test_a_loop_that_remembers_what_came_before_is_white_at_its_levels() -> None:
    rng, time = np.random.default_rng(1), np.linspace(0.0, STEP * (ROWS - 1), ROWS)
    segment, still = Segment(0, NAMES, time, (time, time)), np.zeros((2, ROWS))
    levels = Levels(
        {"sensor": SENSOR, "torque": TORQUE}, {"command": COMMAND, "position": 1e-7}, time=TIME
    )
    whitener = segment_whitener(segment, KERNELS, levels, still)
    for _ in range(8):
        white = whitener(driven(rng))[:, UNMASKED]
        assert np.mean(white**2, axis=1) == pytest.approx([1.0, 1.0], abs=0.1)
        means = np.array([part.mean(1) * np.sqrt(part.shape[1]) for part in _parts(white)])
        assert np.abs(means).max() < 4.5


def _parts(white: Array) -> list[Array]:
    return np.array_split(white, 12, axis=1)


def test_levels_of_such_a_loop_are_told_from_its_whitened_signals() -> None:
    rng, time = np.random.default_rng(2), np.linspace(0.0, STEP * (ROWS - 1), ROWS)
    own = [Segment(k, NAMES, time, (time, time)) for k in range(4)]
    residuals, still = [driven(rng) for _ in own], [np.zeros((2, ROWS)) for _ in own]
    least = Levels({"sensor": 1e-9}, {"command": 5e-5, "position": 1e-7})
    free = ["port:sensor", "own:position", "own:command"]
    found = top = estimated(KERNELS, blocks_of(own, residuals, still, KERNELS), least, free)
    near = None
    for _ in range(4):
        white = [
            segment_whitener(segment, KERNELS, found, rate)(z)[:, UNMASKED]
            for segment, z, rate in zip(own, residuals, still, strict=True)
        ]
        cut = [rate[:, UNMASKED] for rate in still]
        found = inadequate(KERNELS, own, white, cut, top, {"torque": 1e-5}, near, found)
        near = found
    assert found.ports["torque"] == pytest.approx(TORQUE, rel=0.25)
    assert found.ports["torque"] / np.sqrt(found.time) == pytest.approx(
        TORQUE / np.sqrt(TIME), rel=0.1
    )
    assert found.astray["torque"] < 0.02 * TORQUE
    assert found.own["command"] == pytest.approx(COMMAND, rel=0.05)
