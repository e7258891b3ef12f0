"""A user's strict type check sees the types of an installed gmfbo."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

from tests.built_wheel import build_wheel, unpack

RIGHT = """
from gmfbo import FmuTwin, Recording, models_folder, step_reference, write_recording

with FmuTwin(models_folder() / "drive_twin.toml") as twin:
    run = twin.run({"ctl.Kp": 120.0, "ctl.Kd": 5.0}, step_reference(1.0, at=0.1, horizon=1.0))
write_recording(run, "run.csv")
status: str = run.status
rows: int = Recording.read("run.csv", twin).time.size
"""
WRONG = """
from gmfbo import FmuTwin, Nobody, step_reference

reference = step_reference("one")
FmuTwin("drive_twin.toml").run(reference)
"""


@pytest.fixture(scope="module")
def user(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a user, with an environment that holds the wheel and what it depends on."""
    folder = tmp_path_factory.mktemp("user")
    venv.create(folder / "env", symlinks=True)
    (site,) = (folder / "env").glob("lib/python*/site-packages")
    unpack(build_wheel(folder), site)
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")
    return folder


def check(user: Path, program: str) -> subprocess.CompletedProcess[str]:
    """Check a program as its writer would; the cache is shared between the checks."""
    (user / "program.py").write_text(program, encoding="utf-8")
    python = user / "env" / "bin" / "python"
    options = ["--strict", "--python-executable", str(python), "--cache-dir", str(user / "cache")]
    return subprocess.run(
        [sys.executable, "-m", "mypy", *options, "program.py"],
        cwd=user,
        env={},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_a_right_program_passes(user: Path) -> None:
    checked = check(user, RIGHT)
    assert checked.returncode == 0, checked.stdout


@pytest.mark.slow
def test_control_wrong_names_and_arguments_are_found(user: Path) -> None:
    checked = check(user, WRONG)
    assert checked.returncode == 1
    assert 'Module "gmfbo" has no attribute "Nobody"' in checked.stdout
    assert 'Argument 1 to "step_reference" has incompatible type "str"' in checked.stdout
    assert 'Missing positional argument "reference" in call to "run"' in checked.stdout


def test_the_marker_is_in_the_wheel(user: Path) -> None:
    assert list(user.glob("env/lib/python*/site-packages/gmfbo/py.typed"))


@pytest.mark.slow
def test_control_without_the_marker_there_are_no_types(user: Path) -> None:
    (marker,) = user.glob("env/lib/python*/site-packages/gmfbo/py.typed")
    marker.rename(user / "py.typed")
    checked = check(user, RIGHT)
    (user / "py.typed").rename(marker)
    assert "missing library stubs or py.typed marker" in checked.stdout
