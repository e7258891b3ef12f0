"""TDMS files written by npTDMS."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording
from tests.recordings.twin_words import AXIS

nptdms: Any = pytest.importorskip("nptdms", reason="npTDMS is missing; pip install 'gmfbo[tdms]'")

START = np.datetime64("2026-01-02T03:04:05.000000")
FAST = np.sin(np.arange(400) * 1e-3)
SLOW = np.cos(np.arange(100) * 4e-3)


def wave(group: str, name: str, values: Any, step: float, unit: str = "", late: int = 0) -> Any:
    return nptdms.ChannelObject(
        group,
        name,
        values,
        properties={
            "wf_increment": step,
            "wf_start_offset": 0.0,
            "wf_start_time": START + np.timedelta64(late, "us"),
            "wf_samples": len(values),
            "unit_string": unit,
        },
    )


def write(path: Path, channels: list[Any], root: dict[str, Any] | None = None) -> Path:
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([nptdms.RootObject(properties=root or {}), *channels])
    return path


def test_waveforms_keep_their_rate_start_and_unit(tmp_path: Path) -> None:
    path = write(
        tmp_path / "run.tdms",
        [
            wave("fast", "reference", FAST, 1e-3, "rad"),
            wave("fast", "position", np.rad2deg(FAST), 1e-3, "deg"),
            wave("slow", "torque_command", 1e3 * SLOW, 4e-3, "mNm", late=500),
        ],
        {"ctl.Kp": 90.5, "author": "Eva"},
    )
    recording = Recording.read(path, AXIS)
    position, torque = recording.signal("position"), recording.signal("torque_command")
    np.testing.assert_allclose(position[np.isfinite(position)], FAST, atol=1e-14)
    np.testing.assert_allclose(torque[np.isfinite(torque)], SLOW, atol=1e-14)
    instants = recording.time[np.isfinite(torque)]
    np.testing.assert_allclose(instants, 0.5e-3 + np.arange(100) * 4e-3, atol=1e-12)
    assert recording.parameters == {"ctl.Kp": 90.5}
    assert recording.start_time == "2026-01-02T03:04:05.000000Z"


def test_a_group_takes_its_clock_from_its_time_channel(tmp_path: Path) -> None:
    plain = [
        nptdms.ChannelObject("Data", "Time", np.arange(400.0), properties={"unit_string": "ms"}),
        nptdms.ChannelObject("Data", "reference", FAST),
        nptdms.ChannelObject("Data", "position", FAST),
        nptdms.ChannelObject("Notes", "text", ["a", "b"]),
    ]
    recording = Recording.read(write(tmp_path / "run.tdms", plain), AXIS)
    np.testing.assert_allclose(recording.time, np.arange(400) * 1e-3, atol=1e-15)
    np.testing.assert_array_equal(recording.signal("position"), FAST)


def test_a_channel_of_points_in_time_is_a_clock(tmp_path: Path) -> None:
    stamps = START + np.arange(400) * np.timedelta64(1000, "us")
    plain = [
        nptdms.ChannelObject("Data", "stamp", stamps),
        nptdms.ChannelObject("Data", "reference", FAST),
    ]
    recording = Recording.read(write(tmp_path / "run.tdms", plain), AXIS)
    np.testing.assert_allclose(recording.time, np.arange(400) * 1e-3, atol=1e-12)


def test_a_needed_channel_without_a_clock_or_of_another_length_is_refused(tmp_path: Path) -> None:
    bare = [nptdms.ChannelObject("Data", "reference", FAST)]
    with pytest.raises(RecordingError, match=r"expected a column 'time'.* sample_time = "):
        Recording.read(write(tmp_path / "bare.tdms", bare), AXIS)
    uneven = [
        nptdms.ChannelObject("Data", "time", np.arange(400) * 1e-3),
        nptdms.ChannelObject("Data", "reference", FAST),
        nptdms.ChannelObject("Data", "position", SLOW),
    ]
    with pytest.raises(RecordingError, match=r"'Data/position' has 100 values, expected 400"):
        Recording.read(write(tmp_path / "uneven.tdms", uneven), AXIS)


def test_another_file_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "run.tdms"
    path.write_text("time,a\n0,1\n" * 50)
    with pytest.raises(RecordingError, match=r"run\.tdms: expected a TDMS file, got") as said:
        Recording.read(path)
    assert "\n" not in str(said.value)
