"""Two rows at one instant, a clock that jitters, and rows put on an even clock."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, models_folder
from gmfbo.errors import RecordingError
from gmfbo.objective.fit import nrmse
from gmfbo.recordings import Recording, SignalSpec
from gmfbo.recordings.writing.writer import write_recording
from tests.recordings.twin_words import TwinWords


@dataclass(frozen=True)
class Resampling(TwinWords):
    """Words of a twin whose file states a step."""

    resample: float | None = None


AXIS = (
    SignalSpec("reference", "reference", unit="rad", driven=True),
    SignalSpec("position", "position", unit="rad"),
)


def write(folder: Path, text: str) -> Path:
    path = folder / "run.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_messages_of_one_instant_fill_each_others_blanks(tmp_path: Path) -> None:
    path = write(tmp_path, "time,a,b\n0,1,\n0,,5\n1,2,\n1,,6\n2,3,\n2,,7\n")
    recording = Recording.read(path)
    np.testing.assert_array_equal(recording.time, [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(recording.signal("a"), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(recording.signal("b"), [5.0, 6.0, 7.0])
    assert "3 instants stand in several rows" in recording.notes[0]


def test_after_an_event_the_last_value_counts(tmp_path: Path) -> None:
    recording = Recording.read(write(tmp_path, "time,r\n0,0\n1,0\n1,5\n2,5\n3,5\n"))
    np.testing.assert_array_equal(recording.time, [0.0, 1.0, 2.0, 3.0])
    np.testing.assert_array_equal(recording.signal("r"), [0.0, 5.0, 5.0, 5.0])


def test_a_fault_below_joined_rows_is_told_with_its_own_line(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="line 6: time goes back from 3 s to 2 s"):
        Recording.read(write(tmp_path, "time,r\n0,0\n1,0\n1,5\n3,5\n2,5\n"))


def test_an_even_clock_has_no_note(tmp_path: Path) -> None:
    """Negative control."""
    assert Recording.read(write(tmp_path, "time,r\n0,0\n1,0\n2,1\n")).notes == ()


def test_rows_are_put_on_an_even_clock_where_that_is_asked_for(tmp_path: Path) -> None:
    text = "time,reference,position\n0,0,0\n1,1,1\n2.5,2,2.5\n9,9,9\n10,9,\n"
    twin = Resampling(AXIS, resample=0.5)
    recording = Recording.read(write(tmp_path, text), twin)
    np.testing.assert_allclose(recording.time, 0.5 * np.arange(21), atol=1e-12)
    # A measured signal lies on the line between its samples, up to the last of them.
    position = recording.signal("position")
    np.testing.assert_allclose(position[:19], 0.5 * np.arange(19), atol=1e-12)
    assert np.isnan(position[19:]).all()
    # A command is held.
    np.testing.assert_array_equal(recording.signal("reference")[:7], [0, 0, 1, 1, 1, 2, 2])
    assert "resampled to a row each 0.5 s, as stated" in recording.notes[0]


def test_a_gap_is_refused_unless_it_is_resampled(tmp_path: Path) -> None:
    path = write(tmp_path, "time,reference,position\n0,0,0\n1,1,1\n2,2,2\n9,9,9\n")
    with pytest.raises(RecordingError, match="there is a gap of 7 s"):
        Recording.read(path, Resampling(AXIS))
    assert len(Recording.read(path, Resampling(AXIS, resample=1.0))) == 10


def test_a_step_far_too_short_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "time,reference,position\n0,0,0\n1,1,1\n2,2,2\n")
    with pytest.raises(RecordingError, match="resample = 1e-08 makes 200000001 rows"):
        Recording.read(path, Resampling(AXIS, resample=1e-8))


def test_a_twin_follows_a_jittering_recording_of_itself(tmp_path: Path) -> None:
    """The oracle is the twin: what it computes between its steps is a line, so nearly nothing."""
    twin_file = tmp_path / "twin.toml"
    text = (models_folder() / "servo_axis.toml").read_text(encoding="utf-8")
    twin_file.write_text(text.replace('fmu = "', f'fmu = "{models_folder().as_posix()}/'))
    rng = np.random.default_rng(5)
    with FmuTwin(twin_file) as twin:
        time = 1e-3 * np.arange(1001.0)
        smooth = Recording(time=time, signals={"reference": 0.2 * np.sin(6.0 * time) ** 2})
        truth = twin.run({}, smooth)
        rows = np.sort(rng.choice(1001, 700, replace=False))
        rows = np.union1d(rows, np.arange(0, 1001, 2))
        seen = Recording(time=time[rows], signals={n: v[rows] for n, v in truth.signals.items()})
        path = tmp_path / "seen.csv"
        write_recording(seen, path)
        bare = "\n".join(x for x in path.read_text().splitlines() if not x.startswith("# gmfbo"))
        path.write_text(bare + "\n")
        read = Recording.read(path, twin)
        assert "rows come 0.001 to 0.002 s apart" in read.notes[0]
        again = twin.run({}, read)
        assert nrmse(again, read, "position") < 2e-3
