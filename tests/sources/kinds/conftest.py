"""Small FMUs, compiled from `small.c` with one habit of vendors' FMUs each."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path

import pytest

SOURCE = Path(__file__).with_name("small.c")
TWIN = """
name = "small"
fmu = "small.fmu"
step = 1e-3
[inputs]
reference = "reference"
[outputs]
position = "position"
length = "length"
"""
Make = Callable[..., Path]


def compiled(folder: Path, name: str, source: Path, options: Sequence[str]) -> Path:
    """A shared library for this machine."""
    library = folder / name
    subprocess.run(
        [sys.executable, "-m", "ziglang", "cc", "-shared", "-fPIC", "-O1", "-w",
         "-fno-sanitize=undefined", *options, "-o", str(library), str(source)],
        check=True,
        cwd=folder,
    )  # fmt: skip
    return library


@pytest.fixture
def small(tmp_path: Path) -> Make:
    """Makes `small.fmu` with these macros, and the twin file that names it."""
    if find_spec("ziglang") is None or sys.platform != "linux":
        pytest.skip("needs the compiler of gmfbo[tests], on Linux")

    def make(
        *macros: str, fmi: int = 2, top: str = "", end: str = "", beside: Sequence[Path] = ()
    ) -> Path:
        options = [f"-D{macro}" for macro in macros] + (["-DFMI3"] if fmi == 3 else [])
        library = compiled(tmp_path, "small.so", SOURCE, [*options, *map(str, beside)])
        place = "binaries/linux64" if fmi == 2 else "binaries/x86_64-linux"
        with zipfile.ZipFile(tmp_path / "small.fmu", "w") as archive:
            arrays = "_arrays" if "ARRAYS" in macros else ""
            archive.write(SOURCE.with_name(f"small{fmi}{arrays}.xml"), "modelDescription.xml")
            for file in (library, *beside):
                archive.write(file, f"{place}/{file.name}")
        twin = tmp_path / "twin.toml"
        twin.write_text(top + TWIN + end, encoding="utf-8")
        return twin

    return make
