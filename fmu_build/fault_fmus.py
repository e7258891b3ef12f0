"""FMUs with one fault each, for the tests; nearly all share a library."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

from fmu_build.archive import pack
from fmu_build.compile import Compiler
from fmu_build.declaration import read_declaration
from fmu_build.description import model_description
from fmu_build.fmu import WRAPPER
from fmu_build.header import variables_header
from fmu_build.platforms import Platform

FOLDER = Path(__file__).resolve().parent / "faults"
# What is tested is a process and its system's answer; elsewhere there is none of it to test.
_PLATFORMS = ("linux-x86_64", "linux-aarch64")
_LIBRARY, _ABSENT = "fault", "libgmfbo_absent"
_SOURCES = ["faults.c", "hostile.c"]
_CAPABILITIES = {"canGetAndSetFMUstate": "false", "canSerializeFMUstate": "false"}


@dataclass(frozen=True)
class Fault:
    """A line of `faults.toml`.

    Attributes
    ----------
    name : str
        Of the FMU.
    behaviour : str
        What `faults.c` calls it.
    variant : str
        Macro that the library is compiled with; empty for the common one.
    library : str
        File name of the library, without suffix.
    flags : mapping of str to str
        Attributes of CoSimulation in the description.
    """

    name: str
    behaviour: str = ""
    variant: str = ""
    library: str = _LIBRARY
    flags: Mapping[str, str] = field(default_factory=dict)


def read_faults() -> list[Fault]:
    """Return the FMUs that `faults.toml` lists."""
    table = tomllib.loads((FOLDER / "faults.toml").read_text(encoding="utf-8"))
    return [Fault(**entry) for entry in table["fault"]]


def build_faults(
    compiler: Compiler, targets: Sequence[Platform], work: Path
) -> Iterator[tuple[str, bytes]]:
    """Build all of them: file names and contents.

    Parameters
    ----------
    compiler : Compiler
        Who compiles.
    targets : sequence of Platform
        For which platforms; those that have no such FMUs are passed over.
    work : Path
        Empty folder to compile in.
    """
    chosen = [target for target in targets if target.name in _PLATFORMS]
    declaration = read_declaration(FOLDER / "declaration.toml")
    sources = {path.name: path.read_bytes() for path in sorted(FOLDER.glob("*.[ch]"))}
    sources["fmi2.h"] = (WRAPPER / "fmi2.h").read_bytes()
    sources["variables.h"] = variables_header(declaration).encode()
    for name, data in sources.items():
        (work / name).write_bytes(data)
    digest = hashlib.sha256(repr(sorted(sources.items())).encode()).hexdigest()[:16]
    libraries: dict[str, dict[str, bytes]] = {}
    for fault in read_faults():
        if fault.variant not in libraries:
            libraries[fault.variant] = {
                f"binaries/{target.fmi_folder}/": _library(compiler, target, work, fault.variant)
                for target in chosen
            }
        guid = f"{fault.behaviour or fault.name}-{digest}"
        files = {"modelDescription.xml": _description(model_description(declaration, guid), fault)}
        for folder, library in libraries[fault.variant].items():
            files[f"{folder}{fault.library}.so"] = library
        yield f"{fault.name}.fmu", pack(files)


def _library(compiler: Compiler, target: Platform, work: Path, variant: str) -> bytes:
    sources = list(_SOURCES)
    if variant:
        (work / "variant.c").write_text(f'#define {variant}\n#include "faults.c"\n')
        sources[0] = "variant.c"
    if variant == "NEEDS_ABSENT":
        # Linked, so that the loader looks for it, and left out of the FMU.
        absent = f"{_ABSENT}{target.suffix}"
        (work / absent).write_bytes(compiler.shared_library(work, ["absent.c"], _ABSENT, target))
        sources.append(absent)
    return compiler.shared_library(work, sources, _LIBRARY, target)


def _description(xml: bytes, fault: Fault) -> bytes:
    root = ET.fromstring(xml)
    root.set("modelName", fault.name)
    interface = root.find("CoSimulation")
    assert interface is not None
    for name, value in {**_CAPABILITIES, **fault.flags}.items():
        interface.set(name, value)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"
