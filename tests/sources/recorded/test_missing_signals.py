"""A compared signal that a recording lacks is told, with the nearest column."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gmfbo import FmuTwin, check
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.missing_signals import missing_signals
from tests.diagnosis.short_recordings import SERVO


@pytest.fixture(scope="module")
def twin() -> FmuTwin:
    return SERVO.twin()


@pytest.fixture(scope="module")
def sound() -> list[Recording]:
    return SERVO.recordings({})


def without(recording: Recording, name: str, **others: str) -> Recording:
    signals = {others.get(n, n): c for n, c in recording.signals.items() if n != name or others}
    return replace(recording, signals=signals)


def test_nothing_is_missing_where_all_was_recorded(twin: FmuTwin, sound: list[Recording]) -> None:
    assert missing_signals(twin, sound) == []


def test_nearest_column_is_named(twin: FmuTwin, sound: list[Recording]) -> None:
    (found,) = missing_signals(twin, [without(sound[0], "position", position="Position")])
    assert found.signal == "position"
    assert found.what == "no column position; did you mean 'Position'?"
    assert "motion is not compared" in found.without


def test_all_columns_of_its_name_are_named(twin: FmuTwin, sound: list[Recording]) -> None:
    signals = {name: column for name, column in sound[0].signals.items() if name != "position"}
    both = dict.fromkeys(("a/position", "b/position"), sound[0].signal("position"))
    (found,) = missing_signals(twin, [replace(sound[0], signals={**signals, **both})])
    assert found.what == "no column position but 2 in groups: 'a/position', 'b/position'"


def test_column_without_values_is_missing(twin: FmuTwin, sound: list[Recording]) -> None:
    blank = sound[0].with_signals({"torque_command": np.full(len(sound[0]), np.nan)})
    (found,) = missing_signals(twin, [blank])
    assert found.what == "column torque_command holds no value"
    assert "the controller is not checked" in found.without


def test_check_tells_which_recording_lacks_it(twin: FmuTwin, sound: list[Recording]) -> None:
    seen = check(twin, [sound[0], without(sound[1], "torque_command")], jobs=1)
    told = [(f.kind, f.recording, f.signal) for f in seen.findings]
    assert told == [("missing_column", "rec1.csv", "torque_command")]
