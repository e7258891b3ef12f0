"""The wheel installs and works on each Python that the project promises, where it is present."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.built_wheel import ROOT, build_wheel

VERSIONS = ("3.11", "3.12", "3.13")


def candidates(version: str) -> Iterator[str]:
    """Interpreters of a version: those that pyenv built, then the one on PATH."""
    yield from map(str, sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python")))
    yield f"python{version}"


def interpreter(version: str) -> str:
    """Return an interpreter that starts and is of this version, or skip the test."""
    asked = ["-c", "import sys; print('%d.%d' % sys.version_info[:2])"]
    for python in candidates(version):
        try:
            answer = subprocess.run([python, *asked], capture_output=True, text=True, check=True)
        except (OSError, subprocess.CalledProcessError):  # a shim may lead to no interpreter
            continue
        if answer.stdout.strip() == version:
            return python
    pytest.skip(f"no python{version} on PATH or in ~/.pyenv/versions")


def run(*command: str | Path, folder: Path) -> str:
    """Run a command where the checkout cannot be seen, and return what it prints."""
    environment = {k: value for k, value in os.environ.items() if not k.startswith("PYTHON")}
    finished = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert finished.returncode == 0, finished.stdout + finished.stderr
    return finished.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_wheel(tmp_path_factory.mktemp("wheel"))


@pytest.mark.slow
@pytest.mark.parametrize("version", VERSIONS)
def test_an_installed_wheel_inspects_and_simulates(
    version: str, wheel: Path, tmp_path: Path
) -> None:
    run(interpreter(version), "-m", "venv", "env", folder=tmp_path)
    programs = tmp_path / "env" / "bin"
    constraints = ROOT / "tests/constraints.txt"
    run(programs / "pip", "install", "-q", "-c", constraints, wheel, folder=tmp_path)
    where = "import gmfbo; print(gmfbo.models_folder())"
    models = Path(run(programs / "python", "-c", where, folder=tmp_path).strip())
    assert models.is_relative_to(tmp_path)
    gmfbo = programs / "gmfbo"
    assert "Usage: gmfbo" in run(gmfbo, "--help", folder=tmp_path)
    assert "runs here: yes" in run(gmfbo, "inspect", models / "drive_twin.fmu", folder=tmp_path)
    twin = models / "drive_twin.toml"
    assert "rows" in run(gmfbo, "simulate", twin, "--out", "run.csv", folder=tmp_path)
    assert (tmp_path / "run.csv").stat().st_size > 1000
