"""Rows that are slower than the controller show gross errors of it alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, check
from gmfbo.diagnosis.checking.text import check_lines
from gmfbo.diagnosis.locating.parities import parities
from gmfbo.diagnosis.locating.slower_rows import are_slower, computing_interval, row_interval
from gmfbo.recordings.recording import Recording
from tests.diagnosis.servo_recordings import rewritten
from tests.diagnosis.short_recordings import SERVO, open_small

SAID = "rows are slower than the controller (5 ms, while it computes every 1 ms)"


def every(rows: int, recording: Recording) -> Recording:
    signals = {name: column[::rows] for name, column in recording.signals.items()}
    return replace(recording, time=recording.time[::rows], signals=signals)


@pytest.fixture(scope="module")
def twin(tmp_path_factory: pytest.TempPathFactory) -> FmuTwin:
    """A twin file that says how its reference runs, so that nothing but the rows is open."""
    stated = 'reference = { variable = "reference", interpolation = "hold" }'
    folder = tmp_path_factory.mktemp("twin")
    return rewritten("servo_axis", folder, {'reference = "reference"': stated})


@pytest.fixture(scope="module")
def slow() -> list[Recording]:
    """An axis of which the twin knows all, logged five times more slowly than it is controlled."""
    return [every(5, recording) for recording in SERVO.recordings({}, seconds=2.0)]


def test_a_right_controller_is_not_told_wrong_by_slow_rows(
    twin: FmuTwin, slow: list[Recording]
) -> None:
    seen = check(twin, slow, jobs=1)
    assert seen.findings == ()
    assert seen.parity_why_not.startswith(SAID)
    assert seen.logged == {}
    lines = check_lines(seen)
    (row,) = [line for line in lines if line.startswith("torque command ")]
    assert row.split()[-2] == "-"


def test_what_no_course_between_two_rows_makes_is_told(
    twin: FmuTwin, slow: list[Recording]
) -> None:
    """Negative control: the command is three times as large as it should be."""
    wrong = [r.with_signals({"torque_command": 3.0 * r.signal("torque_command")}) for r in slow]
    seen = check(twin, wrong, jobs=1)
    assert {(f.kind, f.signal) for f in seen.findings} == {("controller_parity", "torque_command")}
    assert all("between its rows" in finding.what for finding in seen.findings)
    assert seen.logged == {}


def test_the_controller_is_as_fast_as_its_command_changes(twin: FmuTwin, tmp_path: Path) -> None:
    """A controller of 5 ms in a twin of 1 ms is checked on rows of 5 ms."""
    slower = twin.with_file(
        twin.file.model_copy(update={"parameters": {**twin.file.parameters, "sample_time": 5e-3}})
    )
    recordings = [every(5, r) for r in SERVO.recordings({}, seconds=2.0, twin=slower)]
    for own, interval in ((twin, 1e-3), (slower, 5e-3)):
        case = open_small(own, recordings)
        try:
            told = computing_interval(case.base, "torque_command", own.step)
            assert told == pytest.approx(interval)
            rows = row_interval(case, "position")
            assert rows == pytest.approx(5e-3)
            checked = parities(case, case.base)
        finally:
            case.simulations.close()
        assert are_slower(rows, told) == (own is twin) == checked.slower_rows
        if own is slower:
            assert checked.controller is not None
            assert not checked.controller.fails


def test_a_clock_that_is_rounded_makes_no_wrong_controller(twin: FmuTwin) -> None:
    """Rows of 2.5 ms, whose times are written in whole milliseconds: 2 and 3 ms apart."""
    rounded = []
    for recording in SERVO.recordings({}, seconds=2.0):
        rows = np.arange(0.0, recording.time[-1], 2.5e-3, dtype=np.float64)
        signals = {n: np.interp(rows, recording.time, c) for n, c in recording.signals.items()}
        rounded.append(replace(recording, time=np.asarray(np.round(rows, 3)), signals=signals))
    seen = check(twin, rounded, jobs=1)
    assert {finding.kind for finding in seen.findings} == {"jitter"}
    assert seen.parity_why_not.startswith("rows are slower than the controller")
    assert seen.logged == {}
