"""Rows whose stamps jitter: a logger that samples evenly is told from one that does not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.nuisance_columns import Logging, logging_of
from gmfbo.diagnosis.comparison.segments import Segment
from gmfbo.diagnosis.runs.scored_record import _uniform
from gmfbo.diagnosis.scoring.nuisances import Alignment
from gmfbo.recordings.recording import Recording

Array = NDArray[np.float64]

EVEN = 4e-3 * np.arange(2000, dtype=np.float64)
JITTER = 2e-4 * np.random.default_rng(0).standard_normal(EVEN.size)


def motion(time: Array) -> Array:
    return np.sin(2.0 * np.pi * 0.7 * time)


def segment(time: Array) -> Segment:
    return Segment(0, ("position",), time, (time,))


def logging(*segments: Segment) -> Logging:
    alignments = {"position": Alignment(0.0, 0.0)}
    return logging_of(segments, {"position": 2.0}, {"position": 0.0}, frozenset(), alignments)


def test_even_rows_have_no_late_stamps_and_no_such_error() -> None:
    even = segment(EVEN)
    assert not even.late.any()
    assert "stamps" not in {kind for kind, _ in logging(even).names}


def test_how_late_a_stamp_is_is_read_off_the_even_clock() -> None:
    late = segment(EVEN + JITTER).late
    assert np.abs(late - (JITTER - JITTER.mean())).max() < 2e-5


@pytest.mark.parametrize("share", [0.05, 0.2])
def test_rows_that_were_put_on_an_even_clock_know_their_stamps(share: float) -> None:
    jitter = share * 4e-3 * np.random.default_rng(1).uniform(-1.0, 1.0, EVEN.size)
    late = _uniform_late(EVEN + jitter)
    assert np.abs(late - (jitter - jitter.mean())).max() < 0.02 * 4e-3


def _uniform_late(time: Array) -> Array:
    recording = Recording(time=time, signals={"position": motion(time)}, name="jitter.csv")
    signal = _uniform("position", recording, np.ones(time.size, dtype=bool), time[0], time[-1])
    return Segment(0, ("position",), signal.time, (signal.time,), signal.stamps).late


def test_at_one_the_signals_are_those_of_an_even_clock() -> None:
    jittering = segment(EVEN + JITTER)
    errors = logging(jittering)
    nuisances = np.array([float(kind == "stamps") for kind, _ in errors.names])
    assert nuisances.sum() == 1.0
    values = motion(jittering.time)[None]
    seen = errors.seen(jittering, values, nuisances)[0]
    before = np.std(values[0] - motion(EVEN))
    assert np.std(seen - motion(EVEN)) < 0.1 * before
    (column,) = errors.slopes(jittering, values, 0.0 * nuisances)[nuisances > 0.0]
    assert column[0] == pytest.approx(seen - values[0])
