"""Rows whose stamps jitter: a logger that samples evenly is told from one that does not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.nuisance_columns import Logging, logging_of
from gmfbo.diagnosis.comparison.segments import Segment
from gmfbo.diagnosis.scoring.nuisances import Alignment

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
