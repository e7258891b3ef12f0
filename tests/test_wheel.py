"""The wheel: what an installed gmfbo can do without its sources."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.built_wheel import ROOT, build_wheel, unpack


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of an unpacked wheel, built from the checkout."""
    folder = tmp_path_factory.mktemp("wheel")
    unpack(build_wheel(folder), folder / "site")
    return folder / "site"


def run(installed: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python with the unpacked wheel in front of everything else."""
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=installed.parent,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def files_below(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*.*")}


def test_a_wheel_carries_fmus_twin_files_and_the_c_master(installed: Path) -> None:
    models = installed / "gmfbo" / "_models"
    carried = files_below(models)
    assert carried == files_below(ROOT / "models")
    assert "drive_twin.fmu" in carried


def test_a_wheel_carries_the_examples(installed: Path, tmp_path: Path) -> None:
    assert files_below(installed / "gmfbo" / "_examples") == files_below(
        ROOT / "notebooks" / "examples"
    )
    finished = run(installed, "-m", "gmfbo", "examples", str(tmp_path / "tour"))
    assert finished.returncode == 0, finished.stderr
    assert (tmp_path / "tour" / "vendor" / "x7.fmu").is_file()


def test_a_wheel_runs_its_own_models(installed: Path) -> None:
    code = (
        "import gmfbo; from gmfbo import models_folder; print(gmfbo.__file__);"
        "twin = gmfbo.FmuTwin(models_folder() / 'drive_twin.toml');"
        "print(twin.run((100.0, 6.0), gmfbo.step_reference()).status); twin.close()"
    )
    finished = run(installed, "-W", "error", "-c", code)
    home, status = finished.stdout.split()
    assert Path(home).is_relative_to(installed)
    assert status == "ok"


def test_a_wheel_says_that_building_needs_the_sources(installed: Path) -> None:
    finished = run(installed, "-m", "gmfbo", "build")
    assert finished.returncode == 2
    assert "needs the sources in fmu_build/" in finished.stderr
    assert finished.stderr.count("\n") == 1
