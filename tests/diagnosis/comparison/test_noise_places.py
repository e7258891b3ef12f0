"""Levels of noise are told apart by the paths on which it reaches the signals."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.noise.high_band import BlockGroup, estimated, whittle
from gmfbo.diagnosis.comparison.noise.places import Levels, blocks_of
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.comparison.segments import Segment
from gmfbo.diagnosis.comparison.whitener import Whitening, segment_whitener

STEP, ROWS = 1e-3, 4000
NAMES = ("position", "command")
LOOP = np.exp(np.log(0.9) * np.linspace(0.0, 199.0, 200))
KERNELS = PortKernels(
    {"sensor": {"position": np.eye(1, 200)[0] - 0.05 * LOOP, "command": -40.0 * LOOP}}, STEP
)


def segments(count: int) -> list[Segment]:
    time = np.linspace(0.0, STEP * (ROWS - 1), ROWS)
    return [Segment(k, NAMES, time, (time, time)) for k in range(count)]


def noise(levels: Levels, rng: np.random.Generator) -> NDArray[np.float64]:
    read = levels.ports["sensor"] * rng.standard_normal(ROWS)
    signals = [np.convolve(read, KERNELS.kernels["sensor"][name])[:ROWS] for name in NAMES]
    own = [levels.own[name] * rng.standard_normal(ROWS) for name in NAMES]
    return np.stack(signals) + np.stack(own)


@pytest.mark.parametrize(
    ("sensor", "position", "command"),
    [(3e-5, 1e-6, 3e-4), (1e-7, 3e-5, 3e-4), (3e-5, 3e-5, 1e-3)],
    ids=["read by the controller", "added by the logger", "both"],
)
def test_levels_are_recovered_from_their_own_noise(
    sensor: float, position: float, command: float
) -> None:
    truth = Levels({"sensor": sensor}, {"position": position, "command": command})
    rng = np.random.default_rng(1)
    own = segments(4)
    residuals = [noise(truth, rng) for _ in own]
    still = [np.zeros((2, ROWS)) for _ in own]
    least = Levels({"sensor": 1e-8}, {"position": 1e-7, "command": 1e-5})
    free = ["port:sensor", "own:position", "own:command"]
    found = estimated(KERNELS, blocks_of(own, residuals, still, KERNELS), least, free)
    seen = {"position": position, "command": command}
    for name in NAMES:
        if seen[name] > 0.05 * sensor:
            assert found.own[name] == pytest.approx(seen[name], rel=0.1)
    if sensor > 1e-6:
        assert found.ports["sensor"] == pytest.approx(sensor, rel=0.1)
    else:
        assert found.ports["sensor"] < 0.1 * position


@pytest.mark.parametrize("is_robust", [False, True], ids=["whittle", "robust"])
def test_slopes_over_the_levels_are_differences_of_the_value(is_robust: bool) -> None:
    truth = Levels({"sensor": 3e-5}, {"position": 1e-5, "command": 1e-3}, jitter=1e-5)
    rng = np.random.default_rng(3)
    own = segments(2)
    moving = [np.stack([np.linspace(0.0, 2.0, ROWS), np.zeros(ROWS)]) for _ in own]
    residuals = [noise(truth, rng) for _ in own]
    free = ["port:sensor", "own:position", "own:command", "jitter"]
    blocks = blocks_of(own, residuals, moving, KERNELS)
    groups = [BlockGroup.of(one, truth, free, KERNELS) for one in blocks]
    x = np.log([2e-5, 2e-5, 5e-4, 3e-5])

    def value(at: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        found = [g.judged(np.exp(2.0 * at), g.robust if is_robust else whittle) for g in groups]
        return sum(v for v, _ in found), np.sum([s for _, s in found], axis=0)

    steps = 1e-5 * np.eye(x.size)
    differences = [(value(x + h)[0] - value(x - h)[0]) / 2e-5 for h in steps]
    np.testing.assert_allclose(value(x)[1], differences, rtol=1e-5)


def test_whitened_noise_is_white_and_of_unit_variance() -> None:
    truth = Levels({"sensor": 3e-5}, {"position": 1e-5, "command": 1e-3})
    rng = np.random.default_rng(2)
    segment = segments(1)[0]
    white = Whitening((segment_whitener(segment, KERNELS, truth, np.zeros((2, ROWS))),))
    (z,) = white([noise(truth, rng)])
    inner = z[:, 50:-50]
    assert inner.var(axis=1) == pytest.approx([1.0, 1.0], abs=0.08)
    assert abs(np.mean(inner[0] * inner[1])) < 0.06
    assert abs(np.mean(inner[:, 1:] * inner[:, :-1])) < 0.06


def test_noise_of_another_place_is_not_white() -> None:
    """Negative control: the logger's noise whitened as if the controller had read it."""
    truth = Levels({"sensor": 1e-9}, {"position": 3e-5, "command": 1e-4})
    taken = Levels({"sensor": 3e-5}, {"position": 1e-6, "command": 1e-4})
    segment = segments(1)[0]
    white = Whitening((segment_whitener(segment, KERNELS, taken, np.zeros((2, ROWS))),))
    (z,) = white([noise(truth, np.random.default_rng(3))])
    assert z.var(axis=1).max() > 2.0
