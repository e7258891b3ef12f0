"""Twin files and FMUs for the tests of the driver; the FMUs are the committed, compiled ones."""

from __future__ import annotations

import re
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Protocol

import pytest

from gmfbo.sources.fmu_file.models import models_folder
from tests.sources.worker.processes import forget_earlier

TEST_FMUS = Path(__file__).resolve().parents[1] / "fmus"

AXIS = """
name = "axis"
fmu = "FMU"
step = 1e-3
[inputs]
reference = "reference"
[outputs]
position = "position"
drive_voltage = "drive_voltage"
[gains]
"kp" = [40.0, 320.0]
"kv" = [60.0, 500.0]
"""

FAULTY = """
name = "faulty"
fmu = "FMU"
step = 1e-3
[inputs]
reference = "reference"
[outputs]
position = "position"
"""

LOOP = """
name = "controller and plant"
step = 1e-3
[fmus]
controller = { kind = "pd_filtered", sample_time = 1e-3, kp = 500.0 }
plant = "FMU"
[wires]
"controller.measured" = "plant.true_position"
"plant.port.force" = "controller.u"
[inputs]
reference = "controller.reference"
[outputs]
position = "plant.true_position"
force = "controller.u"
[parameters]
"plant.kp" = 0.0
"plant.kv" = 0.0
"plant.mass" = 2.0
"plant.viscous_friction" = 60.0
"""


class WriteTwin(Protocol):
    def __call__(self, text: str, fmu: Path | None = None) -> Path: ...


@pytest.fixture(autouse=True)
def only_own_processes() -> None:
    """A test counts the processes that it starts."""
    forget_earlier()


@pytest.fixture
def write_twin(tmp_path: Path) -> WriteTwin:
    """Writes a twin file; FMU in its text stands for the path of an FMU, the axis if none."""

    def write(text: str, fmu: Path | None = None) -> Path:
        path = tmp_path / "twin.toml"
        path.write_text(text.replace("FMU", str(fmu or models_folder() / "linear_axis.fmu"), 1))
        return path

    return write


@pytest.fixture
def axis(write_twin: WriteTwin) -> Path:
    """Twin file of the linear axis."""
    return write_twin(AXIS)


@pytest.fixture
def faulty(write_twin: WriteTwin) -> Path:
    """Twin file of the FMU that fails on purpose."""
    return write_twin(FAULTY, TEST_FMUS / "faulty.fmu")


Repack = Callable[..., Path]


@pytest.fixture
def repack(tmp_path: Path) -> Repack:
    """Writes a copy of an FMU with its description edited and its members renamed or replaced."""

    def write(
        source: Path | None = None,
        *,
        edits: Mapping[str, str] | None = None,
        rename: Mapping[str, str] | None = None,
        members: Mapping[str, bytes] | None = None,
    ) -> Path:
        path = tmp_path / "repacked.fmu"
        with (
            zipfile.ZipFile(source or models_folder() / "linear_axis.fmu") as original,
            zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as copy,
        ):
            for name in original.namelist():
                if name in (members or {}):
                    continue
                content = original.read(name)
                if name == "modelDescription.xml":
                    text = content.decode()
                    for pattern, replacement in (edits or {}).items():
                        text, count = re.subn(pattern, replacement, text)
                        assert count, f"nothing to edit: {pattern}"
                    content = text.encode()
                copy.writestr((rename or {}).get(name, name), content)
            for name, content in (members or {}).items():
                copy.writestr(name, content)
        return path

    return write


@pytest.fixture
def own_temporary_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A temporary folder of the test's own, which has to be empty in the end."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.setenv("TMPDIR", str(folder))
    yield folder
    assert list(folder.iterdir()) == []
