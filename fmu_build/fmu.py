"""One FMU: its sources gathered, compiled for each platform and packed."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from fmu_build.archive import pack
from fmu_build.compile import Compiler
from fmu_build.declaration import Declaration
from fmu_build.description import model_description
from fmu_build.header import variables_header, variables_table
from fmu_build.platforms import Platform
from fmu_build.universal import join_slices

WRAPPER = Path(__file__).resolve().parent / "wrapper"


def build_fmu(
    declaration: Declaration, compiler: Compiler, targets: Sequence[Platform], work: Path
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
    """
    resources = _files_below(declaration.folder / "resources")
    sources = _c_sources(declaration)
    guid = _guid(declaration, sources, resources)
    files = {f"resources/{name}": data for name, data in resources.items()}
    files["modelDescription.xml"] = model_description(declaration, guid)
    if targets:
        sources["variables.c"] = variables_table(declaration, guid).encode()
        for name, data in sources.items():
            (work / name).parent.mkdir(parents=True, exist_ok=True)
            (work / name).write_bytes(data)
        units = sorted(name for name in sources if name.endswith(".c"))
        files |= _binaries(declaration.name, units, compiler, targets, work)
    return pack(files)


def _binaries(
    name: str, sources: list[str], compiler: Compiler, targets: Sequence[Platform], work: Path
) -> dict[str, bytes]:
    slices: dict[str, list[bytes]] = {}
    for target in targets:
        library = compiler.shared_library(work, sources, name, target)
        slices.setdefault(f"binaries/{target.fmi_folder}/{name}{target.suffix}", []).append(library)
    return {
        path: libraries[0] if len(libraries) == 1 else join_slices(libraries)
        for path, libraries in slices.items()
    }


def _c_sources(declaration: Declaration) -> dict[str, bytes]:
    """Wrapper, headers and sources of the model, all by their name in one flat folder."""
    sources = {path.name: path.read_bytes() for path in sorted(WRAPPER.glob("*.[ch]"))}
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
    declaration: Declaration, sources: Mapping[str, bytes], resources: Mapping[str, bytes]
) -> str:
    """Hash of all that the FMU is made from, so that equal guids mean equal behaviour."""
    digest = hashlib.sha256(model_description(declaration, guid=""))
    digest.update(variables_table(declaration, guid="").encode())
    for group in (sources, resources):
        for name in sorted(group):
            digest.update(f"\0{name}\0{len(group[name])}\0".encode())
            digest.update(group[name])
    return digest.hexdigest()[:32]
