"""`check`, `simulate` and `diagnose` of absurd recordings: a result or one clear line."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.cli import main
from gmfbo.sources.fmu_file.models import models_folder

ROWS = 300
TIME = 2e-3 * np.arange(ROWS, dtype=np.float64)
STEP = np.where(TIME < 0.05, 0.0, 0.01)
AXIS = str(models_folder() / "linear_axis.toml")

# Reference and position, and what the refusal says; empty: a result.
CASES: dict[str, tuple[NDArray[np.float64], NDArray[np.float64], str]] = {
    "position never sampled": (STEP, np.full(ROWS, np.nan), "expected at least 64 rows of one"),
    "reference never sampled": (np.full(ROWS, np.nan), STEP, "expected .*blank"),
    "infinite": (STEP, np.full(ROWS, np.inf), "expected a number, got 'inf'"),
    "beyond any sensor": (STEP, np.full(ROWS, 1e308), r"expected values below 1e\+100"),
    "denormal": (np.full(ROWS, 5e-324), np.full(ROWS, 5e-324), ""),
    "constant": (np.full(ROWS, 0.5), np.full(ROWS, 0.5), ""),
    "one sample": (STEP[:1], STEP[:1], "expected at least 64 rows .*, got 1; record longer"),
    "three samples": (STEP[:3], STEP[:3], "expected at least 64 rows .*, got 3; record longer"),
}


def written(folder: Path, name: str) -> str:
    reference, position, _ = CASES[name]
    rows = zip(TIME.tolist(), reference.tolist(), position.tolist(), strict=False)
    lines = ["time,reference,position", *(f"{t!r},{r!r},{p!r}" for t, r, p in rows), ""]
    path = folder / "run.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    return str(path)


def outcome(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Exit status, and the one line of a refusal."""
    status = main(arguments)
    said = capsys.readouterr().err
    if status:
        assert status in (2, 3), said
        assert said.count("\n") == 1
        assert said.startswith("gmfbo: ")
    return status, said


@pytest.mark.parametrize("name", CASES)
def test_check_gives_a_result_or_one_line(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    expected = CASES[name][2]
    status, said = outcome(["check", AXIS, written(tmp_path, name), "--jobs", "1"], capsys)
    assert (status == 0) == (not expected), said
    assert re.search(expected, said)


@pytest.mark.parametrize("command", ["check", "diagnose"])
def test_ten_million_samples_are_refused_in_one_line(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "long.h5"
    rows = 10_000_000
    with h5py.File(path, "w") as file:
        file["time"] = 1e-3 * np.arange(rows)
        file.create_dataset("reference", shape=rows, dtype="f8", chunks=(100_000,))
        file.create_dataset("position", shape=rows, dtype="f8", chunks=(100_000,))
    arguments = [command, AXIS, str(path)]
    arguments += ["--out", str(tmp_path / "out")] if command == "diagnose" else []
    status, said = outcome(arguments, capsys)
    assert status == 2
    assert "expected at most 1000000 rows, got 10000000" in said


@pytest.mark.parametrize("name", CASES)
def test_simulate_gives_a_trajectory_or_one_line(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.csv"
    arguments = ["simulate", AXIS, "--reference", written(tmp_path, name), "--out", str(out)]
    status, said = outcome(arguments, capsys)
    # A constant signal has no range to divide its error by; the trajectory is written all the same.
    assert status == 0 or out.exists() or "expected" in said


@pytest.mark.parametrize("name", ["position never sampled", "denormal", "one sample"])
def test_diagnose_gives_a_diagnosis_or_one_line(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    arguments = ["diagnose", AXIS, written(tmp_path, name), "--out", str(out), "--jobs", "1"]
    status, said = outcome(arguments, capsys)
    assert (out / "diagnosis.json").exists() == (status == 0), said
