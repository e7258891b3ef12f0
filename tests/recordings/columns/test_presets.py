"""Columns of known loggers; the rows are of our own, the headers as the loggers write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import InputError
from gmfbo.recordings import Recording, SignalSpec
from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
from gmfbo.recordings.columns.presets import PRESETS, find_preset, preset_columns
from gmfbo.recordings.reader import read_columns
from gmfbo.recordings.recording import read_recording
from tests.recordings.twin_words import TwinWords

UNITS = {"reference": "rad", "position": "rad", "velocity": "rad/s", "current": "A"}
AXIS = TwinWords(tuple(SignalSpec(name, name, unit=unit) for name, unit in UNITS.items()))
VESC = (
    "ms_today;input_voltage;temp_mos_max;temp_motor;current_motor;current_in;d_axis_current;"
    "q_axis_current;erpm;duty_cycle;encoder_position;fault_code;vesc_id;\n"
    "80069026;55.3;24;26.9;0.5;0;0;1.5;0;0;90;0;1;\n"
    "80069046;55.3;24;26.9;0.5;0;0;2.5;0;0;180;0;1;\n"
    "80069066;55.3;24;26.9;0.5;0;0;3.5;0;0;270;0;1;\n"
)


def read(folder: Path, text: str, preset: str) -> Recording:
    path = folder / "run.csv"
    path.write_text(text, encoding="utf-8")
    columns = preset_columns(preset, read_columns(path), UNITS)
    if preset == "halsampler":
        columns["position"] = MappedColumn("column 2")
    return read_recording(path, AXIS, mapping=ColumnMapping(columns))


def test_a_vesc(tmp_path: Path) -> None:
    recording = read(tmp_path, VESC, "vesc")
    np.testing.assert_allclose(np.diff(recording.time), 0.02, rtol=1e-6)
    np.testing.assert_allclose(recording.signal("position"), np.pi * np.array([0.5, 1.0, 1.5]))
    np.testing.assert_array_equal(recording.signal("current"), [1.5, 2.5, 3.5])
    assert "velocity" not in recording.signals  # erpm is no speed without the pole pairs


def test_an_odrive(tmp_path: Path) -> None:
    text = (
        "time,axis0.controller.input_pos,axis0.encoder.pos_estimate,axis0.encoder.vel_estimate,"
        "axis0.motor.current_control.Iq_measured\n0,1,0.5,0.25,3\n0.01,1,0.5,0.25,3\n"
    )
    recording = read(tmp_path, text, "odrive")
    expected = {"reference": 2 * np.pi, "position": np.pi, "velocity": 0.5 * np.pi, "current": 3.0}
    for name, value in expected.items():
        np.testing.assert_allclose(recording.signal(name), value)


def test_of_two_axes_none_is_chosen(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("time,axis0.pos_estimate,axis1.pos_estimate\n0,1,2\n1,1,2\n")
    assert preset_columns("odrive", read_columns(path), UNITS) == {}


def test_twincat_scope_keeps_the_units_of_the_export(tmp_path: Path) -> None:
    text = (
        "Name;SetPos;ActPos;ActVelo\nSymbolName;Axis 1.SetPos;Axis 1.ActPos;Axis 1.ActVelo\n"
        "Unit;° (Angle);° (Angle);°/s (Velocity)\n0;0;180;360\n10;0;180;360\n20;0;180;360\n"
    )
    recording = read(tmp_path, text, "twincat_scope")
    np.testing.assert_allclose(recording.signal("position"), np.pi)
    np.testing.assert_allclose(recording.signal("velocity"), 2 * np.pi)
    np.testing.assert_allclose(recording.time, [0.0, 0.01, 0.02])


@pytest.mark.parametrize("tagged", [True, False])
def test_halsampler_with_and_without_sample_numbers(tmp_path: Path, tagged: bool) -> None:
    rows = [f"{0.5 * k} {0.25 * k}" for k in range(5)]
    text = "\n".join(f"{k + 7} {row}" if tagged else row for k, row in enumerate(rows)) + "\n"
    recording = read(tmp_path, text, "halsampler")
    np.testing.assert_allclose(np.diff(recording.time), 1e-3, rtol=1e-9)


def test_each_preset_names_the_page_that_documents_it() -> None:
    assert all(preset.page.startswith("https://") for preset in PRESETS.values())


def test_an_unknown_preset_is_refused_with_those_that_are() -> None:
    with pytest.raises(InputError, match="no preset 'odrve'; did you mean 'odrive'"):
        find_preset("odrve")
