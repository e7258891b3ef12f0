"""One FMU: its sources gathered, compiled for each platform and packed."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from fmu_build.archive import pack
from fmu_build.compile import Compiler
from fmu_build.declaration import Declaration
from fmu_build.description import model_description
from fmu_build.description3 import model_description3
from fmu_build.header import variables_header, variables_table
from fmu_build.platforms import Platform
from fmu_build.universal import join_slices

WRAPPER = Path(__file__).resolve().parent / "wrapper"
WRAPPER3 = WRAPPER.with_name("wrapper3")
_DESCRIPTIONS = {2: model_description, 3: model_description3}


def build_fmu(
    declaration: Declaration,
    compiler: Compiler,
    targets: Sequence[Platform],
    work: Path,
    fmi: int = 2,
) -> bytes:
    """Contents of the FMU file.

    Parameters
    ----------
    declaration : Declaration
        The model.
    compiler : Compiler
        Who compiles.
    targets : sequence of Platform
        For which platforms; with none the FMU has no binaries.
    work : Path
        Empty folder to compile in.
    fmi : int
        Major version of FMI. An FMI 3.0 library is the FMI 2.0 wrapper with a front; it answers
        the calls of both.
    """
    resources = _files_below(declaration.folder / "resources")
    sources = _c_sources(declaration, fmi)
    guid = _guid(declaration, sources, resources, fmi)
    files = {f"resources/{name}": data for name, data in resources.items()}
    files["modelDescription.xml"] = _DESCRIPTIONS[fmi](declaration, guid)
    if targets:
        sources["variables.c"] = variables_table(declaration, guid).encode()
        for name, data in sources.items():
            (work / name).parent.mkdir(parents=True, exist_ok=True)
            (work / name).write_bytes(data)
        units = sorted(name for name in sources if name.endswith(".c"))
        libraries = {
            target: compiler.shared_library(work, units, declaration.name, target)
            for target in targets
        }
        files |= _binaries(declaration.name, libraries, fmi)
    return pack(files)


def build_plain_fmu(
    folder: Path, compiler: Compiler, targets: Sequence[Platform], work: Path
) -> bytes:
    """Contents of an FMI 3.0 FMU that is written by hand, without wrapper and declaration.

    Parameters
    ----------
    folder : Path
        With `modelDescription.xml` and one C file of the folder's name.
    compiler : Compiler
        Who compiles.
    targets : sequence of Platform
        For which platforms.
    work : Path
        Empty folder to compile in.
    """
    source = f"{folder.name}.c"
    for path in (folder / source, WRAPPER3 / "fmi3.h"):
        (work / path.name).write_bytes(path.read_bytes())
    libraries = {
        target: compiler.shared_library(work, [source], folder.name, target) for target in targets
    }
    files = _binaries(folder.name, libraries, fmi=3)
    files["modelDescription.xml"] = (folder / "modelDescription.xml").read_bytes()
    return pack(files)


def _binaries(name: str, libraries: Mapping[Platform, bytes], fmi: int) -> dict[str, bytes]:
    """Libraries by their place in the archive; FMI 2.0 has one folder for both kinds of Mac."""
    slices: dict[str, list[bytes]] = {}
    for target, library in libraries.items():
        folder = target.fmi_folder if fmi == 2 else target.fmi3_folder
        slices.setdefault(f"binaries/{folder}/{name}{target.suffix}", []).append(library)
    return {
        path: parts[0] if len(parts) == 1 else join_slices(parts) for path, parts in slices.items()
    }


def _c_sources(declaration: Declaration, fmi: int) -> dict[str, bytes]:
    """Wrapper, headers and sources of the model, all by their name in one flat folder."""
    sources = {path.name: path.read_bytes() for path in sorted(WRAPPER.glob("*.[ch]"))}
    if fmi == 3:
        sources |= {path.name: path.read_bytes() for path in sorted(WRAPPER3.glob("*.[ch]"))}
    for path in sorted(declaration.folder.glob("*.h")):
        sources[path.name] = path.read_bytes()
    for name in declaration.sources:
        path = declaration.folder / name
        sources[path.name] = path.read_bytes()
    sources["variables.h"] = variables_header(declaration).encode()
    return sources


def _files_below(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def _guid(
    declaration: Declaration,
    sources: Mapping[str, bytes],
    resources: Mapping[str, bytes],
    fmi: int,
) -> str:
    """Hash of all that the FMU is made from, so that equal guids mean equal behaviour."""
    digest = hashlib.sha256(_DESCRIPTIONS[fmi](declaration, ""))
    digest.update(variables_table(declaration, guid="").encode())
    for group in (sources, resources):
        for name in sorted(group):
            digest.update(f"\0{name}\0{len(group[name])}\0".encode())
            digest.update(group[name])
    return digest.hexdigest()[:32]
