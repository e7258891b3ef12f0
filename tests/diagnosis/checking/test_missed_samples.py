"""Samples that a logger missed are blank to a diagnosis, as `gmfbo check` finds them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import chi2_per_dof
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.diagnosis.checking.consistent_recordings import consistent, without_missed
from gmfbo.diagnosis.fitting.fit import fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import SERVO, multisine

FRICTION = {"coulomb_friction.level": 0.2}
ROWS = np.sort(np.random.default_rng(1).choice(np.arange(100, 1300), 25, replace=False))


def repeating(recording: Recording, *names: str) -> Recording:
    """What a logger writes that misses these rows."""
    rows = np.arange(len(recording))
    rows[ROWS] = -1
    before = np.maximum.accumulate(rows)
    return recording.with_signals({name: recording.signal(name)[before] for name in names})


def blank(recording: Recording, name: str) -> NDArray[np.int64]:
    return np.flatnonzero(np.isnan(recording.signal(name)))


OUTPUTS = ("position", "torque_command")


def test_what_a_logger_repeats_is_blank_and_told() -> None:
    (sound,) = SERVO.recordings(FRICTION, (multisine,))
    with SERVO.twin() as twin:
        (whole,), (note,) = without_missed(twin, [repeating(sound, *OUTPUTS)])
    for name in OUTPUTS:
        np.testing.assert_array_equal(blank(whole, name), ROWS)
    told = "25 rows in rec0.csv repeat the one before while the axis moves"
    assert note == f"{told}: they were taken for blank"


@pytest.mark.parametrize("name", OUTPUTS)
def test_control_a_column_that_repeats_by_itself_stays(name: str) -> None:
    """It may be at a limit, written with few digits, or of a controller slower than the rows."""
    (sound,) = SERVO.recordings(FRICTION, (multisine,))
    repeats = repeating(sound, name)
    coarse = sound.with_signals({n: significant(sound.signal(n), 3) for n in OUTPUTS})
    with SERVO.twin() as twin:
        for recording in (repeats, coarse):
            (whole,), notes = without_missed(twin, [recording])
            assert whole is recording
            assert notes == []


def significant(values: NDArray[np.float64], digits: int) -> NDArray[np.float64]:
    """As printf's %g writes them."""
    return np.array([float(f"{value:.{digits}g}") for value in values])


def test_control_a_recording_without_repeats_stays_as_it_is() -> None:
    (sound,) = SERVO.recordings(FRICTION, (multisine,))
    counts = np.round(sound.signal("position") / 1e-3) * 1e-3
    coarse = sound.with_signals({"position": counts})
    latched = sound.with_signals(
        {"torque_command": np.repeat(sound.signal("torque_command")[::4], 4)}
    )
    with SERVO.twin() as twin:
        for recording in (sound, coarse, latched):
            (whole,), notes = without_missed(twin, [recording])
            assert whole is recording
            assert notes == []


def test_control_what_repeats_rows_farther_before_as_often_repeats_by_chance() -> None:
    """A column of few values, and all that is computed from it."""
    (sound,) = SERVO.recordings(FRICTION, (multisine,))
    drawn = 0.1 * np.random.default_rng(2).integers(0, 4, len(sound)).astype(np.float64)
    few = sound.with_signals(dict.fromkeys(OUTPUTS, drawn))
    with SERVO.twin() as twin:
        (whole,), notes = without_missed(twin, [few])
    assert whole is few
    assert notes == []


def test_several_recordings_are_told_together() -> None:
    spoiled = [repeating(one, *OUTPUTS) for one in SERVO.recordings(FRICTION, seconds=1.4)]
    with SERVO.twin() as twin:
        _, notes = without_missed(twin, spoiled)
    assert [note[:33] for note in notes] == ["50 rows in 2 recordings repeat th"]


def test_a_reference_may_repeat_as_long_as_it_was_asked_to() -> None:
    (sound,) = SERVO.recordings(FRICTION, (multisine,))
    with SERVO.twin() as twin:
        (whole,), notes = without_missed(twin, [repeating(sound, "reference")])
    assert notes == []
    assert not blank(whole, "reference").size


def test_missed_samples_are_no_noise_of_the_position() -> None:
    """Left in, each is off by a row's motion: noise ten times as large, and chi2 five times."""
    (sound,) = SERVO.recordings(FRICTION, (multisine,))
    noise, chi2 = [], []
    for recording in (sound, repeating(sound, *OUTPUTS)):
        with SERVO.twin() as twin:
            given = consistent(twin, [recording], seed=0, jobs=1)
            case = open_case(twin, given.recordings, seed=0, jobs=1)
        start = Hypothesis(case.setting, (Candidate("coulomb_friction", {"level": 0.2}),))
        found = fit(case.misfit, start, case.base.parameters)
        case.simulations.close()
        assert found is not None
        noise.append(case.noise["position"].total)
        chi2.append(chi2_per_dof(found, case.misfit))
    assert noise[1] == pytest.approx(noise[0], rel=0.1)
    assert chi2[1] == pytest.approx(chi2[0], rel=0.1)
