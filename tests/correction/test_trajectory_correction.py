"""The trajectory correction where its answer is known, and against the exact process."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.correction.trajectory_gp import (
    CorrectionSettings,
    Memory,
    Pair,
    TrajectoryCorrection,
)
from gmfbo.errors import InputError

TIME: NDArray[np.float64] = np.asarray(np.arange(1101) * 1e-3, dtype=np.float64)
MEMORIES: tuple[Memory, ...] = ("latest", "accumulate")


def response(bandwidth: float, damping: float = 0.6) -> NDArray[np.float64]:
    """Closed-form second-order step response, step at 0.1 s."""
    t = np.maximum(TIME - 0.1, 0.0)
    fast = bandwidth * np.sqrt(1.0 - damping**2)
    decay = np.exp(-damping * bandwidth * t)
    ratio = damping / np.sqrt(1.0 - damping**2)
    return np.asarray(1.0 - decay * (np.cos(fast * t) + ratio * np.sin(fast * t)))


def rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("memory", MEMORIES)
def test_scale_and_offset_are_undone_also_at_other_gains(memory: Memory) -> None:
    seen, new = response(30.0), response(33.0)
    here, there = np.array([0.4, 0.5]), np.array([0.45, 0.5])
    pair = Pair(TIME, seen, 0.9 * seen + 0.05, here)
    correction = TrajectoryCorrection.fit([pair], CorrectionSettings(memory=memory))
    mean, _ = correction.correct(TIME, new, there)
    assert rms(mean - (0.9 * new + 0.05)) < 0.05 * rms(new - (0.9 * new + 0.05))


def test_time_shift_is_undone_at_the_trained_gains() -> None:
    simulated = response(30.0)
    delayed = np.interp(TIME - 0.004, TIME, simulated, left=0.0)
    correction = TrajectoryCorrection.fit([Pair(TIME, simulated, delayed)])
    mean, std = correction.correct(TIME, simulated)
    assert rms(mean - delayed) < 0.03 * rms(simulated - delayed)
    assert rms(std) < 0.01
    assert correction.held_out_error < 0.05 * correction.uncorrected_error


@pytest.mark.parametrize("memory", MEMORIES)
def test_perfect_twin_stays_as_it_is(memory: Memory) -> None:
    simulated = response(30.0)
    correction = TrajectoryCorrection.fit(
        [Pair(TIME, simulated, simulated, np.array([0.5]))], CorrectionSettings(memory=memory)
    )
    mean, _ = correction.correct(TIME, simulated, np.array([0.5]))
    np.testing.assert_allclose(mean, simulated, atol=2e-3)


def test_thinned_fit_is_as_good_as_the_exact_one() -> None:
    # Fewer samples than the benchmark's 1101, so that the exact process fits in a test.
    rows = slice(0, 1101, 3)
    simulated, measured = response(30.0), response(27.0, 0.5)
    noisy = measured + 1e-3 * np.random.default_rng(0).standard_normal(1101)
    pair = Pair(TIME[rows], simulated[rows], noisy[rows])
    thinned = TrajectoryCorrection.fit([pair], CorrectionSettings(max_points=150))
    exact = TrajectoryCorrection.fit([pair], CorrectionSettings(exact=True))
    errors = [rms(c.correct(TIME, simulated)[0] - measured) for c in (thinned, exact)]
    assert errors[0] < 1.5 * errors[1]
    assert errors[0] < 0.1 * rms(simulated - measured)


def test_noise_of_the_sensor_is_averaged_and_not_reproduced() -> None:
    simulated, measured = response(30.0), response(27.0)
    noisy = measured + 5e-3 * np.random.default_rng(1).standard_normal(1101)
    correction = TrajectoryCorrection.fit([Pair(TIME, simulated, noisy)])
    mean, _ = correction.correct(TIME, simulated)
    assert rms(mean - measured) < 2.5e-3
    assert correction.held_out_error == pytest.approx(5e-3, rel=0.15)


def test_several_runs_are_kept_apart_by_their_gains() -> None:
    # The same twin trajectory with two truths: (t, y) alone cannot tell them apart.
    simulated = response(30.0)
    truths = {0.1: simulated + 0.05, 0.9: simulated - 0.05}
    pairs = [Pair(TIME, simulated, y, np.array([gain])) for gain, y in truths.items()]
    both = TrajectoryCorrection.fit(pairs, CorrectionSettings(memory="accumulate"))
    for gain, truth in truths.items():
        assert rms(both.correct(TIME, simulated, np.array([gain]))[0] - truth) < 2e-3
    last = TrajectoryCorrection.fit(pairs)
    assert rms(last.correct(TIME, simulated)[0] - truths[0.9]) < 2e-3


def test_uncertainty_grows_away_from_the_gains_that_were_run() -> None:
    simulated = response(30.0)
    pair = Pair(TIME, simulated, response(27.0), np.array([0.2]))
    correction = TrajectoryCorrection.fit([pair], CorrectionSettings(memory="accumulate"))
    spread = [rms(correction.correct(TIME, simulated, np.array([g]))[1]) for g in (0.2, 0.4, 0.9)]
    assert spread[0] < spread[1] < spread[2]


def test_missing_samples_are_left_out() -> None:
    simulated, measured = response(30.0), response(27.0)
    gappy = measured.copy()
    gappy[::2] = np.nan
    mean, _ = TrajectoryCorrection.fit([Pair(TIME, simulated, gappy)]).correct(TIME, simulated)
    assert rms(mean - measured) < 0.05 * rms(simulated - measured)


def test_same_data_gives_the_same_correction() -> None:
    pair = Pair(TIME, response(30.0), response(27.0))
    one, two = (TrajectoryCorrection.fit([pair]).correct(TIME, response(31.0)) for _ in range(2))
    np.testing.assert_array_equal(one, two)


def test_unusable_runs_are_refused() -> None:
    simulated = response(30.0)
    with pytest.raises(InputError, match="at least one run of the axis"):
        TrajectoryCorrection.fit([])
    with pytest.raises(InputError, match="leave out runs that failed"):
        Pair(TIME, simulated, np.full_like(simulated, np.nan))
    with pytest.raises(InputError, match="of one length"):
        Pair(TIME, simulated[:-1], simulated)
    with pytest.raises(InputError, match="'accumulate' needs the gains"):
        TrajectoryCorrection.fit(
            [Pair(TIME, simulated, simulated)], CorrectionSettings(memory="accumulate")
        )
