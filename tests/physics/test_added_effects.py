"""Effects that are not part of gmfbo: added from Python or by an installed package."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from gmfbo.diagnosis.engine import diagnose
from gmfbo.errors import InputError
from gmfbo.physics import CATALOGUE, Effect, add_effect, catalogue
from gmfbo.sources.fmu_file.models import models_folder, physics_fmu

OTHER = replace(CATALOGUE["elastic_return"], name="rubber_bellows", contains=(), as_limit={})


@pytest.fixture
def own_catalogue(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a test adds is gone after it."""
    monkeypatch.setattr(CATALOGUE, "_added", {})
    monkeypatch.setattr(CATALOGUE, "_loaded", True)


@pytest.mark.usefixtures("own_catalogue")
def test_an_added_effect_comes_after_those_of_gmfbo() -> None:
    before = list(CATALOGUE)
    add_effect(OTHER)
    add_effect(OTHER)  # a cell that is run twice
    assert list(CATALOGUE) == [*before, "rubber_bellows"]
    assert CATALOGUE["rubber_bellows"] is OTHER
    assert CATALOGUE.added == (OTHER,)
    assert len(CATALOGUE) == len(before) + 1


@pytest.mark.usefixtures("own_catalogue")
@pytest.mark.parametrize(
    ("effect", "message"),
    [
        (replace(OTHER, name="coulomb_friction"), "expected a name that is free"),
        (replace(OTHER, port="shaft"), "expected a port of torque, command, sensor, got 'shaft'"),
    ],
)
def test_an_effect_that_cannot_be_added_is_refused(effect: Effect, message: str) -> None:
    before = dict(CATALOGUE)
    with pytest.raises(InputError, match=message):
        add_effect(effect)
    assert dict(CATALOGUE) == before


@pytest.mark.usefixtures("own_catalogue")
def test_a_diagnosis_asks_for_the_law_of_an_added_effect() -> None:
    add_effect(OTHER)
    with pytest.raises(InputError, match=r"no parameter 'rubber_bellows\.stiffness'; build it in"):
        diagnose(models_folder() / "servo_axis.toml", ["never read.csv"])


def test_the_variable_names_a_physics_fmu_of_ones_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("GMFBO_PHYSICS", raising=False)
    assert physics_fmu() == models_folder() / "physics.fmu"
    monkeypatch.setenv("GMFBO_PHYSICS", str(tmp_path / "physics.fmu"))
    with pytest.raises(InputError, match="GMFBO_PHYSICS: expected a file"):
        physics_fmu()
    (tmp_path / "physics.fmu").touch()
    assert physics_fmu() == tmp_path / "physics.fmu"


BELLOWS = """
from dataclasses import replace
from gmfbo.physics import CATALOGUE
bellows = replace(CATALOGUE["elastic_return"], name="bellows", contains=(), as_limit={})
number = 7
"""


def names_with(folder: Path, entry: str) -> subprocess.CompletedProcess[str]:
    """Install a package as an installer leaves it, and ask a new process for the catalogue."""
    (folder / "rubber.py").write_text(BELLOWS, encoding="utf-8")
    about = folder / "rubber-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: rubber\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[gmfbo.effects]\n{entry}\n")
    code = (
        f"import sys; sys.path[:0] = [{str(folder)!r}, "
        f"{str(Path(catalogue.__file__).parents[2])!r}]\n"
        "from gmfbo.errors import InputError\n"
        "from gmfbo.physics import CATALOGUE\n"
        "for attempt in range(2):\n"
        "    try: print(list(CATALOGUE)[-1])\n"
        "    except InputError as error: print(error)\n"
    )
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)


def test_a_package_adds_an_effect(tmp_path: Path) -> None:
    assert names_with(tmp_path, "bellows = rubber:bellows").stdout == "bellows\n" * 2


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("bellows = rubber:gone", "cannot load rubber:gone (AttributeError: "),
        ("bellows = rubber:number", "expected rubber:number to be a gmfbo.physics.Effect, got int"),
    ],
)
def test_a_broken_package_is_named_each_time(tmp_path: Path, entry: str, message: str) -> None:
    first, second = names_with(tmp_path, entry).stdout.splitlines()
    assert first.startswith("effect 'bellows': ")
    assert message in first
    assert second == first
