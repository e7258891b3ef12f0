"""The twin file of an augmented twin says what that of the twin says."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.sources.export.augmented_file import augmented_twin_file
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin_file.twin_file import TwinFile

EVERYTHING = """
name = "all \\"of\\" it"
fmu = "x.fmu"
step = 1e-3
warmup = 0.25
[inputs]
current = { variable = "drive.iq", column = "iq [mA]", scale = 1e-3, interpolation = "linear" }
[outputs]
position = { variable = "enc.phi", column = "pos", scale = 1.5e-6, offset = "fit" }
torque = { variable = "tau", scale = "kt", uncertain_scale = 0.03, shift_range = [-2e-3, 2e-3] }
command = { variable = "u", logged = "held" }
[parameters]
"mech.J" = 0.1
flag = true
[gains]
"ctl.Kp" = [30.0, 200.0]
"ctl.Ki" = { low = 1.0, high = 9.0, scale = "log" }
"ctl.n" = { low = 1, high = 9, integer = true }
"ctl.Kd" = 4.0
[uncertain]
"mech.J" = [0.06, 0.24]
[ports]
torque = "dist.tau"
[states]
velocity = "mot.w"
[roles]
inertia = "mech.J"
[initial]
"mech.phi0" = "position"
"mech.w0" = 0.5
"mech.i0" = "fit"
"""
KEPT = ("step", "warmup", "inputs", "outputs", "gains", "uncertain", "ports", "states", "roles")


def again(file: TwinFile) -> TwinFile:
    text = augmented_twin_file(file, "augmented.fmu", file.step, "a note", {})
    return TwinFile.parse(text, "again")


@pytest.mark.parametrize(
    "text", [EVERYTHING, *(path.read_text() for path in sorted(models_folder().glob("*.toml")))]
)
def test_all_but_fmus_and_parameters_is_kept(text: str) -> None:
    file = TwinFile.parse(text, "original")
    copy = again(file)
    for field in (*KEPT, "initial"):
        assert getattr(copy, field) == getattr(file, field)
    assert (copy.fmu, copy.fmus, copy.wires, copy.parameters) == ("augmented.fmu", {}, {}, {})
    assert copy.name == f"{file.name}, augmented"


def test_single_values_stand_above_the_tables() -> None:
    head, tables = EVERYTHING.split("[", 1)
    given = "stop_time = true\ntime_limit = 30.0\n"
    file = TwinFile.parse(f"{head}{given}[{tables}", "original")
    copy = again(file)
    assert (copy.stop_time, copy.time_limit) == (True, 30.0)
    assert (copy.warmup, copy.outputs) == (file.warmup, file.outputs)


@given(st.text(min_size=1).filter(lambda t: "\r" not in t and t.isprintable()))
def test_any_name_survives(name: str) -> None:
    quoted = json.dumps(name, ensure_ascii=False).replace("\x7f", "\\u007f")
    file = TwinFile.parse(
        f'name = {quoted}\nfmu = "x.fmu"\nstep = 1e-3\n[outputs]\n{quoted} = "y"\n', "named"
    )
    assert list(again(file).outputs) == [name]


def test_the_note_is_a_comment_of_short_lines(tmp_path: Path) -> None:
    file = TwinFile.parse('name = "n"\nfmu = "x.fmu"\nstep = 1e-3\n[outputs]\na = "y"\n', "noted")
    text = augmented_twin_file(file, "augmented.fmu", 1e-3, "word " * 60, {})
    comments = [line for line in text.splitlines() if line.startswith("#")]
    assert len(comments) > 2
    assert max(map(len, text.splitlines())) <= 100


def test_a_fixed_gain_keeps_the_value_that_the_fmu_has() -> None:
    file = TwinFile.parse(EVERYTHING, "original")
    values = {"ctl.Kd": 5.5, "ctl.Kp": 44.0}
    text = augmented_twin_file(file, "augmented.fmu", file.step, "", values)
    gains = TwinFile.parse(text, "refitted").gains
    assert (gains["ctl.Kd"].low, gains["ctl.Kd"].high) == (5.5, 5.5)
    assert gains["ctl.Kp"] == file.gains["ctl.Kp"]
