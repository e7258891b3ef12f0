"""Noise that a controller saw is read off the recording, and played where it is nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.budget import fast_power
from gmfbo.diagnosis.case import Case
from gmfbo.diagnosis.recorded_noise import RecordedNoise, Showing, above, renewed
from gmfbo.diagnosis.simulations import Simulated
from tests.diagnosis.planted_noise import (
    SPLIT,
    STEP,
    Planted,
    ideal_drive,
    opened,
    planted,
    with_added,
)
from tests.diagnosis.short_recordings import BENCH, SERVO

Array = NDArray[np.float64]

SIGMA = 3e-4
COMMAND_NOISE = SERVO.noise["torque_command"]


@pytest.fixture(scope="module")
def servo() -> Iterator[tuple[Planted, Case]]:
    found = planted(SIGMA)
    with opened(found) as case:
        yield found, case


def played_in(case: Case) -> list[RecordedNoise]:
    """Noise of each recording, all of which have some."""
    found = []
    for noise in case.simulations.noise:
        assert isinstance(noise, RecordedNoise)
        found.append(noise)
    return found


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


def runs(case: Case) -> list[Simulated]:
    return case.simulations.run([case.base.hypothesis.point(case.base.x)])[0]


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
    for noise, column in zip(played_in(case), found.noise, strict=True):
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
    found = planted(SIGMA, axis=SPLIT, twin=ideal_drive(tmp_path, sensor))
    with opened(found) as case:
        assert (case.simulations.reading is None) == (showing is Showing.NEVER)
        for noise, column in zip(played_in(case), found.noise, strict=True):
            assert noise.showing is showing
            assert off_by(noise, column) < 0.05
            assert below(noise, column) < 0.1


def test_with_it_the_command_is_left_with_no_more_than_its_own_noise(
    servo: tuple[Planted, Case],
) -> None:
    """The estimate of a level spreads by 6 %: 250 bins, of which the median is taken."""
    _, case = servo
    with case.simulations.quiet():
        quiet = left_in(case, runs(case), "torque_command")
    for before, after in zip(quiet, left_in(case, runs(case), "torque_command"), strict=True):
        assert after == pytest.approx(COMMAND_NOISE, rel=0.2)
        assert before > 5.0 * COMMAND_NOISE


def test_runs_in_quiet_are_those_of_a_twin_that_knows_no_noise(
    servo: tuple[Planted, Case],
) -> None:
    _, case = servo
    noise, with_noise = case.simulations.noise, runs(case)
    with case.simulations.quiet():
        quiet = runs(case)
    case.simulations.noise = ()
    try:
        unaware = runs(case)
    finally:
        case.simulations.noise = noise
    for a, b, c in zip(quiet, unaware, with_noise, strict=True):
        for name, column in a.response.held.items():
            np.testing.assert_array_equal(column, b.response.held[name])
            assert np.any(column != c.response.held[name])
    for a, b in zip(with_noise, runs(case), strict=True):
        np.testing.assert_array_equal(a.response.held["position"], b.response.held["position"])


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


@pytest.mark.parametrize(("hertz", "least"), [(70.0, 95.0), (120.0, 140.0)])
def test_a_vibration_raises_the_corner_above_itself(hertz: float, least: float) -> None:
    line = 2.0 * SIGMA * np.sin(2.0 * np.pi * hertz * STEP * np.arange(1400))
    with opened(with_added(planted(SIGMA), line)) as case:
        for noise in played_in(case):
            assert noise.corner >= least


def test_a_vibration_in_the_highest_band_leaves_nothing_to_play() -> None:
    line = 2.0 * SIGMA * np.sin(2.0 * np.pi * 250.0 * STEP * np.arange(1400))
    with opened(with_added(planted(SIGMA), line)) as case:
        assert list(case.simulations.noise) == [None, None]


def test_noise_that_the_logger_alone_saw_is_not_played() -> None:
    """The command would tell, had the controller seen it."""
    with opened(planted(SIGMA, is_felt=False)) as case:
        assert list(case.simulations.noise) == [None, None]


def test_counts_of_an_encoder_in_the_twin_are_not_played() -> None:
    """Two encoders count each for itself: what one misses is not what both add."""
    with opened(planted(0.0, axis=SPLIT)) as case:
        assert list(case.simulations.noise) == [None, None]


def test_a_start_in_motion_is_not_taken_for_noise() -> None:
    found = planted(SIGMA / 10.0)
    late = [
        replace(r, time=r.time[400:], signals={n: c[400:] for n, c in r.signals.items()})
        for r in found.recordings
    ]
    with opened(replace(found, recordings=late)) as case:
        for noise, column in zip(case.simulations.noise, found.noise, strict=True):
            assert noise is None or np.std(noise.at_port) < 1.2 * np.std(column)
        assert None in case.simulations.noise


def test_a_twin_that_is_held_on_its_recordings_plays_none() -> None:
    found = BENCH.recordings({}, (lambda t: 2.0 * np.sin(3.0 * np.pi * t),))
    with opened(Planted(BENCH.twin(), found, [])) as case:
        assert case.simulations.tracking is not None
        assert list(case.simulations.noise) == [None]


# ---- each hypothesis reads it again -------------------------------------------------------------


def test_read_again_about_the_same_model_the_noise_stays(servo: tuple[Planted, Case]) -> None:
    _, case = servo
    again = renewed(case.simulations, case.base)
    assert again is not None
    for before, after in zip(played_in(case), again, strict=True):
        assert isinstance(after, RecordedNoise)
        change = np.std(after.at_port - before.at_port)
        assert change < 0.02 * np.std(before.at_port)


def test_without_noise_there_is_none_to_read_again(servo: tuple[Planted, Case]) -> None:
    _, case = servo
    noise = case.simulations.noise
    case.simulations.noise = (None, None)
    try:
        assert renewed(case.simulations, case.base) is None
    finally:
        case.simulations.noise = noise
