"""The files of an augmented FMU: runtime, FMUs, documentation and model description."""

from __future__ import annotations

import hashlib
import io
import re
import struct
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.export.container import Container, toolbox_license
from gmfbo.sources.export.container_description import (
    ExposedParameter,
    Heading,
    Part,
    describe_container,
)
from gmfbo.sources.export.container_wiring import Wiring
from gmfbo.sources.export.exportable import library_for
from gmfbo.sources.fmu_file.description import read_description
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.fmu_file.platforms import Platform
from gmfbo.sources.fmu_file.unpacking import open_archive

_EARLIEST = (1980, 1, 1, 0, 0, 0)  # earliest date of a zip archive
_UNIX = 3
_DESCRIPTION = "modelDescription.xml"


@dataclass(frozen=True)
class Content:
    """Content of an augmented FMU.

    Attributes
    ----------
    binding : Binding
        The twin.
    values : mapping of str to float
        [FMU's unit] Start values over the FMUs' own.
    exposed : tuple of ExposedParameter
        Parameters of the named effects.
    step, internal_step : float
        [s]
    platforms : tuple of Platform
        Platforms with binaries.
    """

    binding: Binding
    values: Mapping[str, float]
    exposed: tuple[ExposedParameter, ...]
    step: float
    internal_step: float
    platforms: tuple[Platform, ...]

    @property
    def identifier(self) -> str:
        """Model identifier, which names the libraries."""
        fmus = self.binding.fmus
        name = fmus[0].identifier if len(fmus) == 1 else self.binding.file.name
        return re.sub(r"\W", "_", name, flags=re.ASCII).lstrip("_0123456789") + "_augmented"

    @property
    def description(self) -> str:
        """Description of the model, for its model description."""
        texts = dict.fromkeys(fmu.description for fmu in self.binding.fmus if fmu.description)
        effects = dict.fromkeys(parameter.name.split(".")[1] for parameter in self.exposed)
        added = f"Augmented by gmfbo with {', '.join(effects)}" if effects else "Refitted by gmfbo"
        return " ".join(
            [
                *(f"{text.rstrip('.')}." for text in texts),
                f"{added}.",
                f"Internal step {self.internal_step!r} s: communication steps have to be whole "
                f"multiples of it; {self.step!r} s is what it was fitted at.",
            ]
        )


def container_archive(container: Container, wiring: Wiring, content: Content) -> bytes:
    """Bytes of the augmented FMU; the same content gives the same bytes."""
    files = dict(_resources_on(container, content.platforms))
    files["documentation/licenses/fmu_manipulation_toolbox.txt"] = toolbox_license()
    files["resources/starts.txt"] = _starts(container, wiring, content.internal_step).encode()
    for platform in content.platforms:
        library = models_folder() / "front" / platform.name / f"gmfbo_front{platform.suffix}"
        entry = f"{platform.fmi_folders[0]}/{content.identifier}{platform.suffix}"
        files[f"binaries/{entry}"] = library.read_bytes()
    for index, path in enumerate(wiring.members.values()):
        _move_libraries(files, f"resources/{index:02x}", path, content.platforms)
    if len(content.binding.fmus) == 1:
        files |= _papers(content.binding)
    xml = _describe(container, wiring, content)
    files[_DESCRIPTION] = _text(xml)
    xml.set("guid", _hash(files))
    files[_DESCRIPTION] = _text(xml)
    return _zipped(files)


def descriptions(binding: Binding) -> list[ET.Element]:
    """Read the model descriptions of a twin's FMUs."""
    roots = []
    for fmu in binding.fmus:
        with open_archive(fmu.path) as archive:
            roots.append(ET.fromstring(archive.read(_DESCRIPTION)))
    return roots


def _describe(container: Container, wiring: Wiring, content: Content) -> ET.Element:
    binding = content.binding
    prefixes = [f"{prefix}." for prefix in binding.file.fmus] or [""]
    parts = [Part(*pair) for pair in zip(prefixes, descriptions(binding), strict=True)]
    name = binding.fmus[0].model_name if len(parts) == 1 else binding.file.name
    references = {**container.references, **dict.fromkeys(wiring.times, container.time)}
    starts = {
        name: _start(binding.variables[name].variable.type, value)
        for name, value in content.values.items()
    }
    heading = Heading(
        name, content.identifier, content.description, content.step, binding.default_start
    )
    return describe_container(heading, parts, content.exposed, references, starts)


def _start(kind: str, value: float) -> str:
    if kind == "Boolean":
        return "true" if value else "false"
    return repr(float(value)) if kind == "Real" else str(round(value))


def _resources_on(
    container: Container, platforms: tuple[Platform, ...]
) -> Iterator[tuple[str, bytes]]:
    """Resources without the libraries of platforms on which the container cannot run."""
    folders = {folder for platform in platforms for folder in platform.fmi_folders}
    for name, data in container.resources.items():
        below = PurePosixPath(name).parts
        of_runtime = below[0] == "runtime"
        of_fmu = len(below) > 3 and below[1] == "binaries"
        if not (of_runtime or of_fmu) or below[2 if of_fmu else 1] in folders:
            yield f"resources/{name}", data


def _starts(container: Container, wiring: Wiring, internal_step: float) -> str:
    """Text of the start values that the entry library sets first."""
    lines = [f"S 0 {_bits(internal_step)}"]
    for name, value in wiring.starts.items():
        kind = container.types[wiring.same_as.get(name, name)]
        text = _bits(value) if kind == "R" else str(round(value))
        lines.append(f"{kind} {container.references[name]} {text}")
    return "\n".join(lines) + "\n"


def _bits(value: float) -> str:
    return struct.pack(">d", value).hex()


def _move_libraries(
    files: dict[str, bytes], folder: str, path: Path, platforms: tuple[Platform, ...]
) -> None:
    """Put an FMU's libraries where the runtime looks: some vendors use other folders and names."""
    fmu = read_description(path)
    for platform in platforms:
        library = library_for(fmu, platform)
        place = f"binaries/{platform.fmi_folders[0]}/{fmu.identifier}{platform.suffix}"
        if library is not None and str(library) != place:
            files[f"{folder}/{place}"] = files.pop(f"{folder}/{library}")


def _papers(binding: Binding) -> dict[str, bytes]:
    with open_archive(binding.fmus[0].path) as archive:
        return {
            name: archive.read(name)
            for name in archive.namelist()
            if (name.startswith("documentation/") and not name.endswith("/")) or name == "model.png"
        }


def _text(xml: ET.Element) -> bytes:
    return bytes(ET.tostring(xml, encoding="utf-8", xml_declaration=True))


def _hash(files: Mapping[str, bytes]) -> str:
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(f"{name}\0{len(files[name])}\0".encode())
        digest.update(files[name])
    return digest.hexdigest()[:32]


def _zipped(files: Mapping[str, bytes]) -> bytes:
    """Zip whose bytes depend on its contents only: sorted, of a fixed date and permissions."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, date_time=_EARLIEST)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = _UNIX
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, files[name])
    return buffer.getvalue()
