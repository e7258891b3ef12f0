"""What a model leaves is told from noise of any colour by whether it moves with the axis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.outside.beyond_library import is_uneven
from gmfbo.diagnosis.outside.moved_residual import chance_of_moving
from tests.diagnosis.short_recordings import BENCH, SERVO, moves, multisine, open_small

Array = NDArray[np.float64]
CHANCE = 0.003


def leaving(case: Case, seed: int, colour: float, swing: float) -> Fitted:
    """A model that leaves coloured noise of five times the size, with the axis's speed in it."""
    rng = np.random.default_rng(seed)
    simulated = []
    for record, run in zip(case.simulations.records, case.base.simulated, strict=True):
        columns = []
        for signal in record.signals:
            rows = signal.values.size
            noise = lfilter([1.0], [1.0, -colour], rng.standard_normal(rows))
            speed = np.abs(np.gradient(run.response.held["position"]))
            size = 1.0 + swing * np.interp(
                np.linspace(0.0, 1.0, rows), np.linspace(0.0, 1.0, speed.size), speed / speed.max()
            )
            level = 5.0 * case.noise[signal.name].total
            columns.append(signal.values + level * size * noise / np.std(noise))
        simulated.append(replace(run, quiet=tuple(columns)))
    residual = case.misfit.residual(simulated)
    return replace(case.base, simulated=simulated, residual=residual)


@pytest.fixture(scope="module")
def case() -> Case:
    recordings = SERVO.recordings({}, (multisine, moves))
    found = open_small(SERVO.twin(), recordings)
    found.simulations.close()
    return found


@pytest.mark.parametrize("colour", [0.0, pytest.param(0.9, marks=pytest.mark.slow), 0.98])
def test_noise_of_any_colour_does_not_move_with_the_axis(case: Case, colour: float) -> None:
    """Of 12 draws one may be beyond what three correlations of 200 stretches give by chance."""
    found = [
        chance_of_moving(case, leaving(case, seed, colour, 0.0), np.random.default_rng(seed))
        for seed in range(12)
    ]
    assert sum(p < CHANCE for p in found) <= 1


def test_what_grows_with_the_speed_does(case: Case) -> None:
    model = leaving(case, 0, 0.9, 6.0)
    assert chance_of_moving(case, model, np.random.default_rng(0)) < CHANCE
    assert is_uneven(case, model, np.random.default_rng(0))


def test_what_the_noise_explains_is_not_asked(case: Case) -> None:
    """Negative control: a right twin leaves no more than the budget."""
    assert not is_uneven(case, case.base, np.random.default_rng(0))


def test_a_twin_that_is_held_on_its_recordings_is_not_judged() -> None:
    """The loop that holds it makes noise follow the motion."""
    recordings = BENCH.recordings({}, (lambda t: 2.0 * np.sin(3.0 * np.pi * t),))
    held = open_small(BENCH.twin(), recordings)
    try:
        assert not is_uneven(held, leaving(held, 0, 0.9, 6.0), np.random.default_rng(0))
    finally:
        held.simulations.close()
