"""The tolerance of a signal is a share of its spectrum; that of a free axis falls as f^-4."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import Recording
from gmfbo.diagnosis.runs.scored_record import Record, ScoredSignal
from gmfbo.diagnosis.scoring.noise_levels import POSITION_TOLERANCE, TOLERANCE, tolerance_covariance
from gmfbo.diagnosis.scoring.whitening import Window, make_window
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.short_recordings import SERVO

Array = NDArray[np.float64]

STEP, ROWS = 1e-3, 4000
TIME = STEP * np.arange(ROWS, dtype=np.float64)
TONE = 4.0  # [Hz]
WINDOW: Window = make_window(0, [STEP], [slice(0, ROWS)])


def tolerated(values: Array, *, is_free: bool, positions: frozenset[str]) -> Array:
    """Tolerated power at each frequency, of a signal that a tracking loop frees or not."""
    signal = ScoredSignal("position", TIME, values, 0.0, values if is_free else None)
    with AugmentedTwin(SERVO.twin(), substeps=1) as simulator:
        recording = Recording(time=TIME, signals={"reference": values}, parameters=SERVO.gains)
        plan = simulator.plan(recording, {})
    record = Record("rec0.csv", plan, (signal,), 0.0, float(TIME[-1]))
    covariance = tolerance_covariance(WINDOW, record, positions)
    return np.asarray(np.real(covariance[:, 0, 0]))


def at(hertz: float) -> int:
    return int(np.argmin(np.abs(WINDOW.frequencies - hertz)))


@pytest.mark.parametrize("hertz", [4.5, 5.0, 5.5])
def test_a_slow_tone_of_a_free_axis_is_tolerated_above_it_as_a_force_would_move_it(
    hertz: float,
) -> None:
    """Half an octave above a tone the same force moves by (f_0/f)^2, and power is its square."""
    tone = np.sin(2.0 * np.pi * TONE * TIME)
    positions = frozenset({"position"})
    held = tolerated(tone, is_free=False, positions=frozenset())
    free = tolerated(tone, is_free=True, positions=positions)
    assert free[at(hertz)] / held[at(hertz)] == pytest.approx((TONE / hertz) ** 4, rel=0.05)


def test_the_power_of_one_over_f_squared_is_tolerated_by_its_share_everywhere() -> None:
    """The taper passes 93 to 95 % of the power; that of a line lies in single bins."""
    bins = np.arange(8, 700)
    frequency = bins / (ROWS * STEP)
    rng = np.random.default_rng(0)
    phases = rng.uniform(0.0, 2.0 * np.pi, bins.size)
    waves = np.cos(2.0 * np.pi * frequency[:, None] * TIME + phases[:, None])
    free = tolerated(waves.T @ frequency**-2.0, is_free=True, positions=frozenset())
    inside = slice(at(10.0), at(100.0))
    expected = TOLERANCE**2 * 0.25 * WINDOW.frequencies[inside] ** -4.0
    share = free[inside] / expected
    assert np.mean(share) == pytest.approx(0.94, abs=0.04)
    assert np.std(share) < 0.12


def test_a_position_is_held_ten_times_tighter_than_other_signals() -> None:
    wave = np.sin(2.0 * np.pi * TONE * TIME)
    position = tolerated(wave, is_free=False, positions=frozenset({"position"}))
    other = tolerated(wave, is_free=False, positions=frozenset())
    ratio = (POSITION_TOLERANCE / TOLERANCE) ** 2
    np.testing.assert_allclose(position, ratio * other, rtol=1e-9)
