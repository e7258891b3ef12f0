"""Noise that a controller saw is read off the recording, and played where it is nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.noise.replayed_noise import (
    RecordedNoise,
    Showing,
    above,
    first_reading,
    settled,
    under_noise,
)
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.scoring.noise_levels import fast_power
from tests.diagnosis.noise.planted_noise import (
    SPLIT,
    STEP,
    Planted,
    ideal_drive,
    opened,
    planted,
    with_added,
)
from tests.diagnosis.short_recordings import BENCH, SERVO, multisine

Array = NDArray[np.float64]

SIGMA = 3e-4
ONE = (multisine,)
COMMAND_NOISE = SERVO.noise["torque_command"]


@pytest.fixture(scope="module")
def servo() -> Iterator[tuple[Planted, Case]]:
    found = planted(SIGMA)
    with opened(found) as case:
        yield found, case


def noise_in(case: Case) -> list[RecordedNoise | None]:
    return settled(case.simulations, case.base, first_reading(case.simulations, case.base))


def all_noise_in(case: Case) -> list[RecordedNoise]:
    """Noise of each recording, all of which have some."""
    found = noise_in(case)
    assert all(noise is not None for noise in found)
    return [noise for noise in found if noise is not None]


def in_band(column: Array, low: float, high: float) -> NDArray[np.complex128]:
    frequency = np.fft.rfftfreq(column.size, STEP)
    spectrum = np.fft.rfft(column * np.hanning(column.size))
    return np.asarray(spectrum[(frequency >= low) & (frequency < high)])


def off_by(found: RecordedNoise, planted_column: Array) -> float:
    """Share of what was planted, by which what is played differs above the corner."""
    truth = in_band(planted_column, 1.4 * found.corner, 450.0)
    error = in_band(found.at_port * found.to_si, 1.4 * found.corner, 450.0) - truth
    return float(np.linalg.norm(error) / np.linalg.norm(truth))


def below(found: RecordedNoise, planted_column: Array) -> float:
    """Share of what was planted that is played below half the corner."""
    slow = in_band(found.at_port * found.to_si, 0.0, 0.5 * found.corner)
    return float(
        np.linalg.norm(slow) / np.linalg.norm(in_band(planted_column, 0.0, 0.5 * found.corner))
    )


def under(case: Case, noise: list[RecordedNoise]) -> list[Simulated]:
    """Each recording under all of its noise."""
    point = case.base.hypothesis.point(case.base.x)
    return [case.simulations.run_under(point, k, own) for k, own in enumerate(noise)]


def runs(case: Case, noise: list[RecordedNoise] | None = None) -> list[Simulated]:
    """Each recording as a hypothesis sees it."""
    hypothesis = replace(case.base.hypothesis, noise=None if noise is None else tuple(noise))
    return case.simulations.run([hypothesis.point(case.base.x)])[0]


def left_in(case: Case, simulated: list[Simulated], name: str) -> list[float]:
    """Fast residual of a signal in each recording."""
    found = []
    for record, run in zip(case.simulations.records, simulated, strict=True):
        for signal, values in zip(record.signals, run.signals, strict=True):
            if signal.name == name:
                found.append(float(np.sqrt(fast_power(signal.values - values))))
    return found


# ---- the noise itself ---------------------------------------------------------------------------


def test_planted_noise_comes_back_above_the_corner_and_not_below(
    servo: tuple[Planted, Case],
) -> None:
    found, case = servo
    for noise, column in zip(all_noise_in(case), found.noise, strict=True):
        assert noise.showing is Showing.A_STEP_LATER
        assert noise.corner <= 100.0
        assert off_by(noise, column) < 0.05
        assert below(noise, column) < 0.05


@pytest.mark.parametrize(
    ("sensor", "showing"),
    [
        ("controller.encoder_offset", Showing.NEVER),  # in the controller, behind the wire
        ("controller.position", Showing.AT_ONCE),  # the end of the wire from the reading
    ],
)
def test_noise_is_found_on_wires_whether_the_output_shows_it_or_not(
    sensor: str, showing: Showing, tmp_path: Path
) -> None:
    found = planted(SIGMA, axis=SPLIT, twin=ideal_drive(tmp_path, sensor), references=ONE)
    with opened(found) as case:
        assert (case.simulations.reading is None) == (showing is Showing.NEVER)
        for noise, column in zip(all_noise_in(case), found.noise, strict=True):
            assert noise.showing is showing
            assert off_by(noise, column) < 0.05
            assert below(noise, column) < 0.1


def test_with_it_the_command_is_left_with_no_more_than_its_own_noise(
    servo: tuple[Planted, Case],
) -> None:
    """The estimate of a level spreads by 6 %: 250 bins, of which the median is taken."""
    _, case = servo
    quiet = left_in(case, runs(case), "torque_command")
    noisy = left_in(case, under(case, all_noise_in(case)), "torque_command")
    for before, after in zip(quiet, noisy, strict=True):
        assert after == pytest.approx(COMMAND_NOISE, rel=0.2)
        assert before > 5.0 * COMMAND_NOISE


def test_a_linear_axis_shows_under_noise_what_it_shows_without(
    servo: tuple[Planted, Case],
) -> None:
    """What is as fast as the noise is not played into what is compared, and nothing else moves.

    That the noise sets in with the recording shakes the loop for 0.3 s.
    """
    _, case = servo
    point = case.base.hypothesis.point(case.base.x)
    for k, noise in enumerate(all_noise_in(case)):
        quiet, shown = runs(case)[k], runs(case, all_noise_in(case))[k]
        all_of_it = case.simulations.run_under(point, k, noise)
        for before, after, noisy in zip(
            quiet.signals, shown.signals, all_of_it.signals, strict=True
        ):
            moved = (after - before)[300:-20]
            assert np.std(moved) < 0.03 * np.std((noisy - before)[300:])


def test_a_model_that_noise_does_not_move_is_not_run_under_it(
    servo: tuple[Planted, Case],
) -> None:
    _, case = servo
    assert under_noise(case.misfit, case.base) is None


@pytest.mark.parametrize("showing", Showing)
def test_the_reading_holds_the_noise_once_however_the_output_shows_it(
    servo: tuple[Planted, Case], showing: Showing
) -> None:
    _, case = servo
    silent = case.nominal[0].response
    column = np.random.default_rng(0).standard_normal(silent.held["position"].size)
    shown = {
        Showing.AT_ONCE: 2.0 * column,
        Showing.A_STEP_LATER: 2.0 * np.concatenate([[0.0], column[:-1]]),
        Showing.NEVER: np.zeros(column.size),
    }[showing]
    held = {**silent.held, "position": silent.held["position"] + shown}
    noise = RecordedNoise("position", 50.0, column, 2.0, showing)
    logged = noise.logged(replace(silent, held=held)).held["position"]
    np.testing.assert_allclose(logged, silent.held["position"] + 2.0 * column, rtol=1e-12)


def test_a_filter_keeps_what_is_fast_and_nothing_of_a_line() -> None:
    time = STEP * np.arange(2000, dtype=np.float64)
    fast = np.sin(2.0 * np.pi * 200.0 * time)
    assert np.std(above(3.0 + 5.0 * time, STEP, 50.0)) < 1e-10
    # The ends of a wave do not join: there its slope jumps, which a sharp corner carries far.
    slow = above(np.sin(2.0 * np.pi * 10.0 * time), STEP, 50.0)
    assert np.abs(slow[200:-200]).max() < 5e-4
    np.testing.assert_allclose(above(fast, STEP, 50.0)[200:-200], fast[200:-200], atol=0.01)


# ---- what is no noise ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("hertz", "least"), [pytest.param(70.0, 95.0, marks=pytest.mark.slow), (120.0, 140.0)]
)
def test_a_vibration_raises_the_corner_above_itself(hertz: float, least: float) -> None:
    line = 2.0 * SIGMA * np.sin(2.0 * np.pi * hertz * STEP * np.arange(1400))
    with opened(with_added(planted(SIGMA, references=ONE), line)) as case:
        for noise in all_noise_in(case):
            assert noise.corner >= least


def test_a_vibration_in_the_highest_band_leaves_nothing_to_play() -> None:
    line = 2.0 * SIGMA * np.sin(2.0 * np.pi * 250.0 * STEP * np.arange(1400))
    with opened(with_added(planted(SIGMA, references=ONE), line)) as case:
        assert noise_in(case) == [None]


def test_noise_that_the_logger_alone_saw_is_not_played() -> None:
    """The command would tell, had the controller seen it."""
    with opened(planted(SIGMA, references=ONE, is_felt=False)) as case:
        assert noise_in(case) == [None]


def test_counts_of_an_encoder_in_the_twin_are_not_played() -> None:
    """Two encoders count each for itself: what one misses is not what both add."""
    with opened(planted(0.0, references=ONE, axis=SPLIT)) as case:
        assert noise_in(case) == [None]


def test_a_start_in_motion_is_not_taken_for_noise() -> None:
    found = planted(SIGMA / 10.0)
    late = [
        replace(r, time=r.time[400:], signals={n: c[400:] for n, c in r.signals.items()})
        for r in found.recordings
    ]
    with opened(replace(found, recordings=late)) as case:
        read = noise_in(case)
        for noise, column in zip(read, found.noise, strict=True):
            assert noise is None or np.std(noise.at_port) < 1.2 * np.std(column)
        assert None in read


def test_a_twin_that_is_held_on_its_recordings_plays_none() -> None:
    found = BENCH.recordings({}, (lambda t: 2.0 * np.sin(3.0 * np.pi * t),))
    with opened(Planted(BENCH.twin(), found, [])) as case:
        assert case.simulations.tracking is not None
        assert noise_in(case) == [None]
