"""A clock that is read in a wrong unit of time is told, in closed loop as in open loop."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin
from gmfbo.errors import RecordingError
from gmfbo.physics import CATALOGUE
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.contradiction import contradiction, refuse_contradictions, scale_doubts
from tests.diagnosis.servo_recordings import rewritten
from tests.diagnosis.short_recordings import (
    BENCH,
    SERVO,
    moves,
    multisine,
    open_small,
    triangle,
)

FRICTION = {"coulomb_friction.level": 0.3}


@pytest.fixture(scope="module")
def servo() -> FmuTwin:
    return SERVO.twin()


def foreign(recording: Recording, factor: float = 1.0) -> Recording:
    """As another program logged it, its clock divided by a factor."""
    return replace(recording, time=recording.time / factor, written_by="")


def rows_each(recording: Recording, rows: int) -> Recording:
    signals = {name: values[::rows] for name, values in recording.signals.items()}
    return replace(recording, time=recording.time[::rows], signals=signals)


@pytest.mark.parametrize("reference", [multisine, moves])
@pytest.mark.parametrize("every", [1, 10])
def test_minutes_are_told_though_physics_is_missing(
    reference: Callable[[NDArray[np.float64]], NDArray[np.float64]], every: int, servo: FmuTwin
) -> None:
    (axis,) = SERVO.recordings(FRICTION, [reference], seconds=2.0)
    with pytest.raises(RecordingError, match=r'^rec0.csv: .* in min: .*unit = "min" }') as told:
        refuse_contradictions(servo, [foreign(rows_each(axis, every), 60.0)])
    seen = re.search(r"mean error is (\S+) %, not (\S+) %", str(told.value))
    assert seen is not None
    assert 2.0 * float(seen[1]) < float(seen[2])


def test_hours_are_told(servo: FmuTwin) -> None:
    """A move of a minute with a row each 0.05 s lasts 0.02 s if hours are read as seconds."""
    (axis,) = SERVO.recordings({}, [moves])
    asked = replace(axis, time=0.05 * np.arange(len(axis), dtype=np.float64))
    along = servo.run({}, asked)
    slow = asked.with_signals(
        {name: np.interp(asked.time, along.time, along.signal(name)) for name in servo.file.outputs}
    )
    with pytest.raises(RecordingError, match="the time seems to be in h: "):
        refuse_contradictions(servo, [foreign(slow, 3600.0)])


def every(recording: Recording, spacing: float) -> Recording:
    """The same at another rate, by interpolation."""
    time = np.arange(0.0, recording.duration, spacing)
    signals = {n: np.interp(time, recording.time, v) for n, v in recording.signals.items()}
    return replace(recording, time=time, signals=signals)


def test_ms_are_told_where_rows_could_be_a_slow_loggers(servo: FmuTwin) -> None:
    """Rows of 50 us that are read in s are 50 steps apart, as of a slow process."""
    (axis,) = SERVO.recordings(FRICTION, [moves], seconds=1.0)
    with pytest.raises(RecordingError, match="the time seems to be in ms: "):
        refuse_contradictions(servo, [foreign(every(axis, 5e-5), 1e-3)])


def test_seconds_that_are_called_ms_are_told(servo: FmuTwin) -> None:
    (axis,) = SERVO.recordings(FRICTION, [moves], seconds=1.4)
    with pytest.raises(RecordingError, match="the time seems to be in s: "):
        refuse_contradictions(servo, [foreign(rows_each(axis, 5), 1e3)])


def test_a_stated_unit_has_the_last_word(tmp_path: Path) -> None:
    states = '[columns]\ntime = { column = "t", unit = "s" }\n\n[ports]'
    stated = rewritten("servo_axis", tmp_path, {"[ports]": states})
    (axis,) = SERVO.recordings({}, [moves])
    fast = foreign(axis, 60.0)
    assert "the time" not in contradiction(stated, fast, stated.run({}, fast))


def test_a_run_that_would_take_too_many_steps_is_not_tried(tmp_path: Path) -> None:
    """2 s in minutes are 120,000 steps: the log is judged in seconds alone."""
    limited = rewritten("servo_axis", tmp_path, {"[ports]": "[limits]\nsteps = 3000\n\n[ports]"})
    (axis,) = SERVO.recordings({}, [moves])
    half = every(axis, 5e-4)
    fast = foreign(half.with_signals({"position": half.time}))
    told = contradiction(limited, fast, limited.run({}, fast))
    assert "the time" not in told


def test_in_open_loop_it_is_a_note(tmp_path: Path) -> None:
    (axis,) = BENCH.recordings({}, [multisine])
    bench = BENCH.twin()
    (note,) = scale_doubts(bench, foreign(axis, 60.0))
    assert "the time seems to be in min" in note
    assert scale_doubts(bench, foreign(axis)) == []


@pytest.mark.parametrize("spacing", [1 / 12_000, 0.02])
def test_a_fast_or_slow_logger_is_not_doubted(spacing: float, servo: FmuTwin) -> None:
    """Negative control: 12 kHz is 5 ms in minutes; the largest of an effect is missing."""
    case = open_small(servo, SERVO.recordings({}, [multisine]))
    case.simulations.close()
    for name in ("coulomb_friction", "transport_delay", "actuator_gain_loss"):
        law = CATALOGUE[name]
        largest = {f"{name}.{p.name}": p.high(case.setting.excitation) for p in law.parameters}
        for axis in SERVO.recordings(largest, (moves, triangle), seconds=0.7):
            fast = foreign(every(axis, spacing))
            told = contradiction(servo, fast, servo.run({}, fast))
            assert "the time" not in told, (name, told)
