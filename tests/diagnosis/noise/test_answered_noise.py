"""A plant that runs on a recorded command is not driven by what answers the encoder's noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.noise.noise_corner import above
from gmfbo.diagnosis.noise.open_loop_noise import ReadNoise, leave_out_noise
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import (
    BENCH,
    SERVO,
    Reference,
    diagnosed,
    moves,
    multisine,
    named,
    open_small,
)

Array = NDArray[np.float64]

STEP, FINE, ROWS = 1e-3, 50, 2000
INERTIA, VISCOUS = 0.0052, 0.012
KP, KD = 52.0, 1.3  # [A/rad, A s/rad]
ENCODER, AMMETER = 4e-5, 0.01  # [rad, A]
REFERENCES: tuple[Reference, ...] = (multisine, moves)
TIMING = ("transport_delay", "actuator_lag", "torsional_compliance", "coulomb_friction")


def encoder_noise(k: int) -> Array:
    return ENCODER * np.random.default_rng([4, k]).standard_normal(ROWS)


def loop_recordings(delay: float) -> list[Recording]:
    """Motor under a sampled PD law that reads a noisy encoder; explicit Euler at 20 us."""
    rng = np.random.default_rng(7)
    time: Array = np.linspace(0.0, (ROWS - 1) * STEP, ROWS)
    constant = BENCH.twin().nominal("torque_constant")
    late = round(delay / STEP * FINE)
    made = []
    for k, reference in enumerate(REFERENCES):
        wanted = np.asarray(0.2 * reference(time))
        encoder = encoder_noise(k)
        current, reading = np.zeros(time.size), np.zeros(time.size)
        position = speed = before = 0.0
        for row in range(time.size):
            reading[row] = position + encoder[row]
            error = wanted[row] - reading[row]
            current[row] = KP * error + KD * (error - before) / STEP
            before = error
            for sub in range(FINE):
                acting = (row * FINE + sub - late) // FINE
                torque = constant * current[acting] if acting >= 0 else 0.0
                speed += STEP / FINE * (torque - VISCOUS * speed) / INERTIA
                position += STEP / FINE * speed
        signals = {
            "current": current + AMMETER * rng.standard_normal(time.size),
            "position": reading,
        }
        made.append(Recording(time=time, signals=signals, name=f"rec{k}.csv", written_by="test"))
    return made


@pytest.fixture(scope="module")
def delayed() -> Iterator[tuple[list[Recording], Case]]:
    recordings = loop_recordings(1.4e-3)
    case = open_small(BENCH.twin(), recordings)
    with case.simulations:
        yield recordings, case


def coherence(column: Array, noise: Array) -> float:
    """Share of a column's power from 60 to 400 Hz that noise of up to 5 rows before explains."""

    def spectra(rows: Array) -> NDArray[np.complex128]:
        # Differenced twice: what leaks from slow motion would pass for fast power.
        fast = np.diff(rows, 2)
        return np.asarray(np.fft.rfft(fast * np.hanning(fast.shape[-1]))[..., kept])

    seen = np.fft.rfftfreq(column.size - 2, STEP)
    kept = (seen > 60.0) & (seen < 400.0)
    late, own = spectra(np.array([np.roll(noise, n) for n in range(6)])).T, spectra(column)
    left = own - late @ np.linalg.lstsq(late, own, rcond=None)[0]
    return 1.0 - float(np.sum(np.abs(left) ** 2) / np.sum(np.abs(own) ** 2))


def test_what_answers_the_noise_is_left_out_of_the_command_and_little_else(
    delayed: tuple[list[Recording], Case],
) -> None:
    recordings, case = delayed
    for k, (recording, record) in enumerate(zip(recordings, case.simulations.records, strict=True)):
        before = recording.signal("current")
        after = record.plan.experiment.inputs["current"]
        noise = encoder_noise(k)
        assert coherence(before, noise) > 0.8
        assert coherence(after, noise) < 0.2
        # What is slower than the noise that was read stays as it was recorded.
        slow = np.fft.rfftfreq(before.size, STEP) < 20.0
        change = np.abs(np.fft.rfft(after - before)[slow])
        assert change.max() < 2e-3 * np.abs(np.fft.rfft(before)[slow]).max()


def test_a_delay_is_named_at_its_size_and_no_shaft_beside_it() -> None:
    diagnosis = diagnosed(BENCH.twin(), loop_recordings(1.4e-3), only=TIMING)
    assert named(diagnosis) == ["transport_delay"]
    assert diagnosis.effects[0].parameters["delay"].value == pytest.approx(1.4e-3, rel=0.1)
    assert any("answers noise of the recorded position" in note for note in diagnosis.notes)


@pytest.mark.slow
def test_an_axis_without_delay_is_only_refitted() -> None:
    diagnosis = diagnosed(BENCH.twin(), loop_recordings(0.0), only=TIMING)
    assert diagnosis.verdict == "parameters"
    assert diagnosis.parameters["inertia"].value == pytest.approx(INERTIA, rel=0.01)


@pytest.mark.parametrize("delay", [0.0, 1.4e-3])
def test_a_delay_is_neither_made_of_the_noise_nor_hidden_by_it(delay: float) -> None:
    """With the noise in the command, 0.8 ms of 1.4 are fitted, and 0.4 ms (gain 19) of none."""
    case = open_small(BENCH.twin(), loop_recordings(delay))
    with case.simulations:
        hypothesis = Hypothesis(case.setting, (Candidate("transport_delay", {"delay": 1.0e-3}),))
        found = fit(case.misfit, hypothesis, case.base.parameters, iterations=10)
    assert found is not None
    if delay:
        (effect,) = found.hypothesis.effects
        assert effect.values["delay"] == pytest.approx(delay, rel=0.05)
    else:
        assert case.base.chi2 - found.chi2 < 4.0


def test_the_loop_that_tracks_follows_the_position_without_its_noise(
    delayed: tuple[list[Recording], Case],
) -> None:
    recordings, case = delayed
    tracking = case.simulations.tracking
    assert tracking is not None
    for recording, measured in zip(recordings, tracking.measured, strict=True):
        before = np.std(np.diff(recording.signal("position"), 2))
        assert np.std(np.diff(measured, 2)) < 0.2 * before


def test_a_command_that_answers_no_noise_is_played_as_it_was_recorded() -> None:
    recordings = BENCH.recordings({}, (multisine, moves))
    with open_small(BENCH.twin(), recordings).simulations as simulations:
        for recording, record in zip(recordings, simulations.records, strict=True):
            played = record.plan.experiment.inputs["current"]
            np.testing.assert_array_equal(played, recording.signal("current"))


@pytest.mark.parametrize("noise", [0.0, 1e-5], ids=["exact", "noisy"])
def test_a_clean_tone_answers_no_noise_whatever_the_inertia(noise: float) -> None:
    """Its fast part is leakage, as is that of what the twin's wrong inertia leaves."""
    axis = replace(BENCH, truth={"inertia": 0.0085}, noise={"position": noise})
    tones: list[Reference] = [
        lambda t: 0.8 * np.sin(2.0 * np.pi * 2.0 * t),
        lambda t: np.sin(2.0 * np.pi * 3.1 * t),
    ]
    recordings = axis.recordings({}, tones, seconds=2.5)
    case = open_small(BENCH.twin(), recordings)
    with case.simulations as simulations:
        assert not any("answers noise" in note for note in case.notes)
        for recording, record in zip(recordings, simulations.records, strict=True):
            played = record.plan.experiment.inputs["current"]
            np.testing.assert_array_equal(played, recording.signal("current"))


@pytest.mark.parametrize("seed", range(20))
def test_the_share_that_answers_is_that_of_a_known_controller(seed: int) -> None:
    """20 draws; of few fast lines, some are matched by chance, in each half by another answer."""
    rng = np.random.default_rng(seed)
    noise, time = rng.standard_normal(ROWS), STEP * np.arange(ROWS)
    read = ReadNoise(noise, STEP, 65.0)
    filtered = 3.0 * noise + 2.0 * np.roll(noise, 1) - np.roll(noise, 2)
    slow = 1e3 * np.sin(2.0 * np.pi * 2.3 * time)
    answer, share = read.answer_in(slow + filtered + rng.standard_normal(ROWS))
    assert share == pytest.approx(14.0 / 15.0, abs=0.05)
    kept = above(filtered, STEP, 65.0)
    assert np.std((answer - kept)[50:-50]) < 0.15 * np.std(kept)
    assert read.answer_in(slow + np.sin(2.0 * np.pi * 70.0 * time))[1] < 0.1
    assert read.answer_in(slow)[1] < 0.1


def test_closed_loops_are_left_alone() -> None:
    case = open_small(SERVO.twin(), SERVO.recordings({}))
    with case.simulations:
        records = case.simulations.records
        assert leave_out_noise(case.simulations, case.rig, case.base) is None
        assert case.simulations.records is records
