"""MDF files written by asammdf."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording
from tests.recordings.twin_words import AXIS

asammdf: Any = pytest.importorskip("asammdf", reason="asammdf is missing; pip install 'gmfbo[mdf]'")

FAST = np.arange(400) * 1e-3
SLOW = 0.5e-3 + np.arange(100) * 4e-3


def signal(name: str, time: Any, values: Any, unit: str = "", **more: Any) -> Any:
    return asammdf.Signal(samples=values, timestamps=time, name=name, unit=unit, **more)


def write(path: Path, groups: dict[str, list[Any]], version: str = "4.10") -> Path:
    with asammdf.MDF(version=version) as file:
        file.start_time = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
        for name, signals in groups.items():
            file.append(signals, acq_name=name)
        file.save(path, overwrite=True)
    return path


def axis_groups() -> dict[str, list[Any]]:
    degrees = np.rad2deg(np.sin(FAST))
    return {
        "1ms": [
            signal("reference", FAST, np.sin(FAST), "rad"),
            signal("position", FAST, degrees, "deg"),
        ],
        "4ms": [signal("torque_command", SLOW, 1e3 * np.cos(SLOW), "mNm")],
        "events": [signal("key", np.array([0.0, 0.0123, 0.3]), np.array([1, 2, 3]))],
    }


@pytest.mark.parametrize(("version", "ending"), [("4.10", "mf4"), ("3.30", "mdf")])
def test_each_channel_keeps_its_rate_and_its_unit(
    tmp_path: Path, version: str, ending: str
) -> None:
    path = write(tmp_path / f"run.{ending}", axis_groups(), version)
    recording = Recording.read(path, AXIS)
    position, torque = recording.signal("position"), recording.signal("torque_command")
    np.testing.assert_allclose(position[np.isfinite(position)], np.sin(FAST), atol=1e-14)
    np.testing.assert_allclose(recording.time[np.isfinite(position)], FAST, atol=1e-12)
    np.testing.assert_allclose(torque[np.isfinite(torque)], np.cos(SLOW), atol=1e-12)
    np.testing.assert_allclose(recording.time[np.isfinite(torque)], SLOW, atol=1e-12)
    assert recording.units["torque_command"] == "N.m"
    assert recording.start_time.startswith("2026-01-02T03:04:05")
    # The channel of events is not named by the twin and has a clock of its own.
    assert recording.time.size == FAST.size + SLOW.size
    assert "key" not in recording.signals


def test_without_a_twin_channels_with_a_steady_clock_are_read(tmp_path: Path) -> None:
    recording = Recording.read(write(tmp_path / "run.mf4", axis_groups()))
    assert list(recording.signals) == ["reference", "position", "torque_command"]


def test_instants_that_differ_by_round_off_are_one_row(tmp_path: Path) -> None:
    near = FAST[::4] * (1.0 + 1e-9)
    groups = {
        "a": [signal("reference", FAST, FAST)],
        "b": [signal("position", near, near)],
    }
    recording = Recording.read(write(tmp_path / "run.mf4", groups), AXIS)
    np.testing.assert_allclose(recording.time, FAST, atol=1e-9)
    assert np.flatnonzero(np.isfinite(recording.signal("position"))).tolist() == list(
        range(0, 400, 4)
    )


def test_one_name_in_two_groups_is_told_apart_by_the_group(tmp_path: Path) -> None:
    groups = {
        "drive": [signal("reference", FAST, FAST), signal("iq", FAST, FAST)],
        "motor": [signal("iq", FAST, 2.0 * FAST)],
    }
    recording = Recording.read(write(tmp_path / "run.mf4", groups), AXIS)
    np.testing.assert_array_equal(recording.signal("motor/iq"), 2.0 * FAST)
    np.testing.assert_array_equal(recording.signal("drive/iq"), FAST)


def test_samples_marked_invalid_are_blank(tmp_path: Path) -> None:
    invalid = np.zeros(400, dtype=bool)
    invalid[7] = True
    groups = {
        "a": [
            signal("reference", FAST, FAST),
            signal("position", FAST, FAST, invalidation_bits=invalid),
        ]
    }
    recording = Recording.read(write(tmp_path / "run.mf4", groups), AXIS)
    assert np.flatnonzero(np.isnan(recording.signal("position"))).tolist() == [7]


def test_a_needed_channel_without_a_steady_clock_is_refused(tmp_path: Path) -> None:
    jumps = np.concatenate([FAST[:100], FAST[100:] + 0.05])
    groups = {"a": [signal("reference", jumps, jumps)]}
    with pytest.raises(RecordingError, match=r"there is a gap of 0\.051 s"):
        Recording.read(write(tmp_path / "run.mf4", groups), AXIS)


def test_numbers_among_the_header_s_properties_are_parameters(tmp_path: Path) -> None:
    path = tmp_path / "run.mf4"
    with asammdf.MDF(version="4.10") as file:
        file.append([signal("reference", FAST, FAST)], acq_name="a")
        file.header.comment = (
            '<HDcomment><TX>x</TX><common_properties><e name="ctl.Kp">90.5</e>'
            '<e name="author">Eva</e></common_properties></HDcomment>'
        )
        file.save(path, overwrite=True)
    assert Recording.read(path, AXIS).parameters == {"ctl.Kp": 90.5}


def test_another_file_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "run.mf4"
    path.write_text("time,a\n0,1\n" * 50)
    with pytest.raises(RecordingError, match=r"run\.mf4: expected an MDF file, got") as said:
        Recording.read(path)
    assert "\n" not in str(said.value)
