"""The next reference lies beside a diagnosis only as long as rivals remain."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import SERVO, diagnosed, multisine, named

LOOP = ("transport_delay", "actuator_lag")
LAG = {"actuator_lag.time": 1.2e-3}  # [s]


@pytest.fixture(scope="module")
def rivals() -> Diagnosis:
    """A lag of the drive that one short recording hardly tells from a dead time."""
    recordings = SERVO.recordings(LAG, (multisine,), seed=8, seconds=0.6)
    return diagnosed(SERVO.twin(), recordings, only=LOOP)


def test_a_small_lag_and_a_small_dead_time_are_rivals(rivals: Diagnosis) -> None:
    (effect,) = rivals.effects
    assert {effect.name, *effect.indistinguishable_from} == set(LOOP)
    told = rivals.next_experiment
    assert told is not None
    assert told.distance >= told.threshold
    assert set(told.separates) == set(LOOP)
    assert set(told.predicted) == set(LOOP)


def test_where_rivals_remain_the_reference_that_separates_them_is_written(
    rivals: Diagnosis, tmp_path: Path
) -> None:
    written = rivals.save(tmp_path)
    assert tmp_path / "next.csv" in written
    with SERVO.twin() as twin:
        played = Recording.read(tmp_path / "next.csv", twin)
    reference = played.signal("reference")
    assert np.all(np.isfinite(reference))
    assert np.ptp(reference) > 0.0
    assert played.time[-1] > 1.0


def test_a_later_diagnosis_without_rivals_removes_the_reference(
    rivals: Diagnosis, tmp_path: Path
) -> None:
    rivals.save(tmp_path)
    written = replace(rivals, next_experiment=None).save(tmp_path)
    assert not (tmp_path / "next.csv").exists()
    assert tmp_path / "next.csv" not in written
    assert Diagnosis.from_json(tmp_path).next_experiment is None


@pytest.mark.slow
def test_the_reference_that_was_chosen_separates_them_once_it_is_recorded(
    rivals: Diagnosis, tmp_path: Path
) -> None:
    """Round trip: played on the axis that has the lag, the lag alone is left."""
    rivals.save(tmp_path)
    with SERVO.twin() as twin:
        played = Recording.read(tmp_path / "next.csv", twin)
    rows = round(played.time[-1] * 1000.0) + 1
    reference = np.interp(np.arange(rows) * 1e-3, played.time, played.signal("reference"))
    first = SERVO.recordings(LAG, (multisine,), seconds=0.6)
    (second,) = SERVO.recordings(LAG, (lambda t: reference,), seconds=rows * 1e-3, seed=6)
    diagnosis = diagnosed(SERVO.twin(), [*first, second], only=LOOP)
    assert named(diagnosis) == ["actuator_lag"]
    assert diagnosis.effects[0].indistinguishable_from == ()
    assert diagnosis.next_experiment is None
