"""A twin file gives a recording's columns their meaning."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo.recordings import Recording, SignalSpec, Trajectory
from gmfbo.recordings.recording import read_recording
from gmfbo.recordings.writing.writer import write_recording
from tests.recordings.twin_words import AXIS, TwinWords


def read(folder: Path, text: str, twin: TwinWords) -> Recording:
    path = folder / "run.csv"
    path.write_text(text, encoding="utf-8")
    return read_recording(path, twin)


def test_scale_and_offset_apply_to_the_column_as_it_stands(tmp_path: Path) -> None:
    twin = TwinWords(
        (
            SignalSpec("position", "pos [x]", scale=2.0, scaled=True, offset=0.5, unit="rad"),
            SignalSpec("current", "iq_mA", scale=1e-3, scaled=True, unit="A"),
        )
    )
    twin = TwinWords((replace(twin.signals[0], column="pos"), twin.signals[1]))
    recording = read(tmp_path, "time,pos [counts],iq_mA [mA]\n0,1,500\n1,2,-250\n", twin)
    np.testing.assert_array_equal(recording.signal("position"), [2.5, 4.5])
    np.testing.assert_array_equal(recording.signal("current"), [0.5, -0.25])
    assert recording.units == {"position": "rad", "current": "A"}


def test_an_offset_without_a_scale_is_added_in_si(tmp_path: Path) -> None:
    twin = TwinWords((SignalSpec("x", "x", offset=0.5, unit="m"),))
    np.testing.assert_array_equal(
        read(tmp_path, "time,x [mm]\n0,1000\n1,2000\n", twin).signal("x"), [1.5, 2.5]
    )


def test_a_header_without_units_is_in_the_twins(tmp_path: Path) -> None:
    recording = read(tmp_path, "time,reference,torque_command\n0,1,2\n1,1,2\n", AXIS)
    assert recording.units == {"reference": "rad", "torque_command": "N.m"}


@pytest.mark.parametrize("unit", ["N.m", "Nm", "J", "N m"])
def test_spellings_of_the_twins_unit_change_nothing(tmp_path: Path, unit: str) -> None:
    recording = read(tmp_path, f"time,reference,torque_command [{unit}]\n0,1,2\n1,1,3\n", AXIS)
    np.testing.assert_array_equal(recording.signal("torque_command"), [2.0, 3.0])
    assert recording.units["torque_command"] == "N.m"


def test_a_unit_that_only_the_fmu_knows_is_compared_as_text(tmp_path: Path) -> None:
    twin = TwinWords((SignalSpec("x", "x", unit="widgets"),))
    assert read(tmp_path, "time,x [widgets]\n0,1\n1,2\n", twin).units == {"x": "widgets"}


def test_other_columns_are_kept_under_their_own_name(tmp_path: Path) -> None:
    recording = read(tmp_path, "time,reference,temp [degC],state\n0,1,20,RUN\n1,1,21,2\n", AXIS)
    np.testing.assert_allclose(recording.signal("temp"), [293.15, 294.15])
    assert set(recording.signals) == {"reference", "temp"}


def test_a_column_named_as_a_tunable_parameter_is_a_schedule(tmp_path: Path) -> None:
    recording = read(tmp_path, "time,reference,ctl.Kp\n0,1,90\n1,1,\n2,1,120\n", AXIS)
    np.testing.assert_array_equal(recording.schedules["ctl.Kp"], [90.0, 90.0, 120.0])
    assert "ctl.Kp" not in recording.signals


def test_a_parameter_that_does_not_change_is_in_force(tmp_path: Path) -> None:
    recording = read(tmp_path, "# ctl.Kp = 90\ntime,reference,mech.J\n0,1,0.1\n1,1,0.1\n", AXIS)
    assert recording.parameters == {"mech.J": 0.1, "ctl.Kp": 90.0}
    assert recording.schedules == {}


def test_numbers_that_name_no_parameter_are_remarks(tmp_path: Path) -> None:
    recording = read(tmp_path, "# operator = 7\n# note = a\ntime,reference\n0,1\n1,1\n", AXIS)
    assert recording.parameters == {}


@pytest.mark.parametrize("ending", [".csv", ".h5"])
def test_our_own_file_holds_signals_already_scaled(tmp_path: Path, ending: str) -> None:
    twin = TwinWords(
        (SignalSpec("position", "counts", scale=1e-3, scaled=True, offset=1.0, unit="rad"),)
    )
    run = Trajectory(
        time=np.array([0.0, 1.0]),
        signals={"position": np.array([0.25, 0.5])},
        units={"position": "rad"},
    )
    path = write_recording(run, tmp_path / f"run{ending}")
    np.testing.assert_array_equal(read_recording(path, twin).signal("position"), [0.25, 0.5])


def test_signals_of_different_rates_keep_their_own_instants(tmp_path: Path) -> None:
    """1 ms and 1.5 ms together make steps of 0.5 and 1 ms; each alone is even."""
    fast, slow = np.arange(0, 30, 2), np.arange(0, 30, 3)
    rows = [
        f"{k / 2},{k if k in fast else ''},{k if k in slow else ''}"
        for k in sorted({*fast.tolist(), *slow.tolist()})
    ]
    text = "time [ms],reference,position\n" + "\n".join(rows) + "\n"
    recording = read(tmp_path, text, AXIS)
    sampled = np.isfinite(recording.signal("position"))
    np.testing.assert_allclose(recording.time[sampled], slow / 2000, rtol=1e-15)
    np.testing.assert_array_equal(recording.signal("position")[sampled], slow)
