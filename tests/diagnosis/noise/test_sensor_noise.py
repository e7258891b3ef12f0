"""Noise of a counting encoder: white while it moves, one constant error while it rests."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.noise.loop_noise import sensor_noise
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.sources.fmu_file.job import Outcome
from gmfbo.sources.twin.response import Response

Array = NDArray[np.float64]

COUNT = 1e-3
QUANTISED = COUNT / np.sqrt(12.0)
ROWS = 20000


def along(position: Array) -> Simulated:
    """A simulated motion."""
    held = {"position": position}
    outcome = Outcome("ok", position.size)
    return Simulated(
        (position,), Response(outcome, held, held, held, {}, {}, np.zeros(position.size))
    )


MOVING = along(np.linspace(0.0, 700.3 * COUNT, ROWS))
RESTING = along(np.full(ROWS, 0.37))


def test_a_moving_encoder_errs_by_a_twelfth_of_its_squared_count() -> None:
    """Widrow (1956): uniform within half a count to each side."""
    noise = sensor_noise(MOVING, "position", QUANTISED, COUNT, np.random.default_rng(0))
    assert np.var(noise) == pytest.approx(COUNT**2 / 12.0, rel=0.02)
    assert np.abs(noise).max() <= 0.5 * COUNT * (1.0 + 1e-9)
    assert abs(np.mean(noise)) < 0.02 * COUNT


def test_a_resting_encoder_errs_by_one_constant_which_each_draw_places_anew() -> None:
    drawn = []
    for seed in range(200):
        noise = sensor_noise(RESTING, "position", QUANTISED, COUNT, np.random.default_rng(seed))
        assert np.ptp(noise) < 1e-12
        drawn.append(noise[0])
    # Uniform: 200 draws of it have that deviation within 15 % with a probability of 1e-4.
    assert np.std(drawn) == pytest.approx(QUANTISED, rel=0.15)
    assert np.abs(drawn).max() <= 0.5 * COUNT * (1.0 + 1e-9)


def test_noise_beyond_the_counts_adds_its_variance() -> None:
    total = 1.5 * QUANTISED
    noise = sensor_noise(MOVING, "position", total, COUNT, np.random.default_rng(1))
    assert np.std(noise) == pytest.approx(total, rel=0.02)


@pytest.mark.parametrize("position", ["position", None])
def test_an_encoder_that_counts_finely_has_white_noise_even_at_rest(position: str | None) -> None:
    resolution = 0.1 * COUNT if position else COUNT
    noise = sensor_noise(RESTING, position, QUANTISED, resolution, np.random.default_rng(2))
    assert np.std(noise) == pytest.approx(QUANTISED, rel=0.02)
    assert abs(np.mean(noise[1:] * noise[:-1])) < 0.03 * QUANTISED**2
