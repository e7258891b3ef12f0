"""What is written is read back, to the last bit."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording, Trajectory, step_reference
from gmfbo.recordings.recording import read_recording
from gmfbo.recordings.writing.writer import write_recording

NAMES = st.one_of(
    st.from_regex(r"[a-z][a-z0-9_.]{0,8}(\[[0-9]{1,2}(,[0-9])?\])?", fullmatch=True),
    st.sampled_from(["Δφ", "a;b", 'say "x"', "torque, desired", "p (raw)", "x = y"]),
).filter(lambda name: name not in ("time", "use", "gmfbo"))
UNITS = st.sampled_from(["", "rad", "N.m", "m", "A", "V", "rad/s", "kg.m2", "1", "widgets"])
VALUES = st.floats(allow_infinity=False, allow_nan=True)


@st.composite
def recordings(draw: Any) -> Recording:
    """Recordings and trajectories of 1 to 12 rows on an even clock."""
    rows = draw(st.integers(1, 12))
    step = draw(st.floats(1e-6, 10.0))
    start = draw(st.floats(-100.0, 100.0)) * step
    time = start + step * np.arange(rows, dtype=np.float64)
    names = draw(st.lists(NAMES, min_size=1, max_size=5, unique=True))
    split = draw(st.integers(1, len(names)))
    columns = {name: draw(arrays(np.float64, rows, elements=VALUES)) for name in names}
    # A whole column on the clock, so that the rows are one signal's instants.
    columns[names[0]] = np.nan_to_num(columns[names[0]], nan=0.5)
    units = {name: draw(UNITS) for name in names}
    content: dict[str, Any] = {
        "time": time,
        "signals": {name: columns[name] for name in names[:split]},
        "schedules": {name: columns[name] for name in names[split:]},
        "units": {name: unit for name, unit in units.items() if unit},
        "parameters": draw(
            st.dictionaries(NAMES, st.floats(allow_nan=False, allow_infinity=False), max_size=3)
        ),
        "use": (start, start + step) if rows > 1 and draw(st.booleans()) else None,
        "start_time": draw(st.sampled_from(["", "2026-01-02T03:04:05+00:00"])),
    }
    if draw(st.booleans()):
        return Recording(**content)
    return Trajectory(
        **content,
        status=draw(st.sampled_from(["ok", "diverged", "timeout"])),
        message=draw(st.text(max_size=10)),
        stopped_at=draw(st.none() | st.floats(0.0, 1.0)),
        seconds=draw(st.floats(0.0, 1.0)),
    )


def assert_same(got: Recording, expected: Recording) -> None:
    assert type(got) is type(expected)
    np.testing.assert_array_equal(got.time, expected.time)
    assert list(got.signals) == list(expected.signals)
    assert list(got.schedules) == list(expected.schedules)
    for name, values in {**expected.signals, **expected.schedules}.items():
        # Bit by bit: minus zero stays minus zero.
        mine = got.signals[name] if name in got.signals else got.schedules[name]
        known = np.isfinite(values)
        np.testing.assert_array_equal(np.isfinite(mine), known)
        assert mine[known].tobytes() == values[known].tobytes()
    for field in ("units", "parameters", "use", "start_time"):
        assert getattr(got, field) == getattr(expected, field), field
    if isinstance(expected, Trajectory):
        for field in ("status", "message", "stopped_at", "seconds"):
            assert getattr(got, field) == getattr(expected, field), field


@pytest.mark.parametrize("ending", [".csv", ".h5"])
@given(recording=recordings())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_recording_comes_back_bit_by_bit(ending: str, recording: Recording) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = write_recording(recording, Path(folder) / f"run{ending}")
        assert_same(read_recording(path), recording)
        assert [p.name for p in Path(folder).iterdir()] == [path.name]


@pytest.mark.parametrize("ending", [".csv", ".h5"])
def test_a_message_with_a_nul_is_kept_without_it(tmp_path: Path, ending: str) -> None:
    run = Trajectory(
        time=np.array([0.0, 0.001]),
        signals={"position": np.array([0.0, 1.0])},
        status="failed",
        message="solver failed\x00 at 3 s",
    )
    back = read_recording(write_recording(run, tmp_path / f"run{ending}"))
    assert isinstance(back, Trajectory)
    assert back.message == run.message == "solver failed\ufffd at 3 s"


def test_our_csv_begins_with_the_version_and_the_gains(tmp_path: Path) -> None:
    run = Trajectory(
        time=np.array([0.0, 0.001]),
        signals={"position": np.array([0.0, 1 / 3])},
        units={"position": "rad"},
        parameters={"ctl.Kp": 90.0},
        use=(0.0, 0.001),
    )
    lines = write_recording(run, tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("# gmfbo = ")
    assert "# ctl.Kp = 90.0" in lines
    assert "# use = 0.0:0.001" in lines
    assert lines[-3:] == ["time [s],position [rad]", "0.0,0.0", "0.001,0.3333333333333333"]


@pytest.mark.parametrize("ending", [".csv", ".h5"])
def test_writing_anew_does_not_make_a_foreign_recording_one_of_ours(
    tmp_path: Path, ending: str
) -> None:
    foreign = tmp_path / "logger.csv"
    foreign.write_text("time,position\n0,1\n1,2\n", encoding="utf-8")
    copy = write_recording(read_recording(foreign), tmp_path / f"copy{ending}")
    assert read_recording(copy).written_by == ""
    run = Trajectory(time=np.array([0.0, 1.0]), signals={"position": np.array([0.0, 1.0])})
    ours = write_recording(run, tmp_path / f"ours{ending}")
    assert read_recording(ours).written_by != ""


def test_a_written_h5_file_is_plain_hdf5(tmp_path: Path) -> None:
    path = write_recording(step_reference(at=0.0, horizon=0.01), tmp_path / "step.h5")
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["reference"][:], np.ones(11))
        assert file["reference"].attrs["unit"] == "rad"
        assert file["time"].attrs["unit"] == "s"


@pytest.mark.parametrize("name", ["two\nlines", " blank", "", "time", "x [rad]"])
def test_a_name_that_csv_would_not_give_back_is_refused(tmp_path: Path, name: str) -> None:
    recording = Recording(time=np.array([0.0, 1.0]), signals={name: np.array([0.0, 1.0])})
    with pytest.raises(RecordingError, match="rename"):
        write_recording(recording, tmp_path / "run.csv")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["use", "gmfbo", "gmfbo.status"])
def test_a_parameter_named_as_a_keyword_of_the_format_is_refused(tmp_path: Path, name: str) -> None:
    recording = Recording(
        time=np.array([0.0]), signals={"x": np.array([0.0])}, parameters={name: 1.0}
    )
    with pytest.raises(RecordingError, match=f"parameter '{name}' cannot be written"):
        write_recording(recording, tmp_path / "run.csv")
    again = read_recording(write_recording(recording, tmp_path / "run.h5"))
    assert again.parameters == {name: 1.0}


def test_one_name_for_a_signal_and_a_schedule_is_refused(tmp_path: Path) -> None:
    recording = Recording(
        time=np.array([0.0]), signals={"x": np.array([0.0])}, schedules={"x": np.array([1.0])}
    )
    for ending, match in ((".csv", "one column only"), (".h5", "two columns of this name")):
        with pytest.raises(RecordingError, match=match):
            write_recording(recording, tmp_path / f"run{ending}")


@pytest.mark.parametrize("name", ["", ".", "/abs", "a//b", "a/", "time"])
def test_a_name_that_hdf5_would_take_for_another_is_refused(tmp_path: Path, name: str) -> None:
    recording = Recording(time=np.array([0.0]), signals={name: np.array([0.0])})
    with pytest.raises(RecordingError, match=r"cannot be stored in HDF5, .*; rename it"):
        write_recording(recording, tmp_path / "run.h5")


def test_a_name_with_a_slash_is_a_dataset_in_a_group(tmp_path: Path) -> None:
    recording = Recording(time=np.array([0.0]), signals={"drive/iq": np.array([2.0])})
    path = write_recording(recording, tmp_path / "run.h5")
    assert read_recording(path).signal("drive/iq")[0] == 2.0
    with h5py.File(path) as file:
        assert file["drive"]["iq"][0] == 2.0


def test_another_ending_or_a_missing_folder_is_refused(tmp_path: Path) -> None:
    recording = step_reference()
    with pytest.raises(RecordingError, match=r"ends in \.csv or \.h5, got '\.xlsx'"):
        write_recording(recording, tmp_path / "run.xlsx")
    with pytest.raises(RecordingError, match="the folder does not exist; create it"):
        write_recording(recording, tmp_path / "no" / "run.csv")
    (tmp_path / "file").touch()
    with pytest.raises(RecordingError, match="a part of the path is a file"):
        write_recording(recording, tmp_path / "file" / "run.csv")
