"""Signals of FMUs under usual names, and the step of a first twin."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import FmuFileError
from gmfbo.recordings.columns.column_mapping import MappedColumn
from gmfbo.sources.first_twin.log_columns import StatedColumns, read_log, step_of
from gmfbo.sources.first_twin.signals import signals_of
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.inspection.inspection import inspect_fmu
from gmfbo.sources.twin_file.twin_file import TwinFile
from tests.sources.conftest import TEST_FMUS

USUAL = {
    "servo_axis": {"reference": "reference", "torque_command": "torque_command"},
    "linear_axis": {"reference": "reference", "voltage": "drive_voltage"},
    "drive_twin": {"reference": "reference", "torque_command": "torque_command"},
}


@pytest.mark.parametrize("name", USUAL)
def test_usual_names_are_those_of_the_shipped_twin_files(name: str) -> None:
    """The twin files were written by hand, by those who made the models."""
    signals = signals_of(inspect_fmu(models_folder() / f"{name}.fmu"))
    shipped = TwinFile.read(models_folder() / f"{name}.toml")
    expected = {**USUAL[name], "position": shipped.outputs["position"].variable}
    usual = {s.name: s.variable.name for s in signals.known.values() if s.usual}
    assert {key: usual.get(key) for key in expected} == expected
    answer = signals.controlled
    assert answer is not None
    assert answer.name == "position"


def test_an_fmu_that_cannot_run_here_is_refused() -> None:
    with pytest.raises(FmuFileError, match="has no binary for this machine"):
        signals_of(inspect_fmu(TEST_FMUS / "no_binary.fmu"))


@pytest.mark.parametrize(
    ("spacing", "step"), [(1e-3, 1e-3), (2e-4, 2e-4), (4e-3, 1e-3), (2.5e-3, 2.5e-3 / 3)]
)
def test_without_a_stated_step_whole_steps_meet_the_rows(
    tmp_path: Path, spacing: float, step: float
) -> None:
    log = tmp_path / "log.csv"
    rows = [f"{time!r},0,0" for time in (np.arange(200) * spacing).tolist()]
    log.write_text("\n".join(["time [s],reference,position", *rows]))
    report = inspect_fmu(models_folder() / "servo_axis.fmu")
    stated = signals_of(report)
    assert step_of(stated, read_log(log, stated, StatedColumns({})))[0] == report.default_step
    silent = signals_of(replace(report, default_step=None))
    found, whence = step_of(silent, read_log(log, silent, StatedColumns({})))
    assert found == pytest.approx(step, rel=1e-5)
    assert whence.startswith("guess: the FMU states none")


def test_a_signal_that_is_left_out_stays_out(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("time,reference,position,velocity\n0,0,0,0\n0.001,0,0,0\n")
    signals = signals_of(inspect_fmu(models_folder() / "servo_axis.fmu"))
    found = read_log(log, signals, StatedColumns({"velocity": MappedColumn("")}))
    assert set(found.mapping.columns) == {"time", "reference", "position"}
