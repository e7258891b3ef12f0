"""Check whether a twin's FMUs can be exported as one, and what is lost by it."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath

from gmfbo.errors import ExportError, FmuFileError
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.fmu_file.description import FmuDescription
from gmfbo.sources.fmu_file.platforms import Platform
from gmfbo.sources.fmu_file.unpacking import open_archive

CONTAINER_PLATFORMS = (
    Platform("linux-x86_64", ("linux64", "x86_64-linux"), ".so"),
    Platform("windows-x86_64", ("win64", "x86_64-windows"), ".dll"),
    Platform("macos-aarch64", ("darwin64", "aarch64-darwin"), ".dylib"),
)
"""Platforms with a runtime in the toolbox, which looks in the first folder of each."""

_LOST = {
    "canGetAndSetFMUstate": "saving and restoring its state",
    "providesDirectionalDerivative": "directional derivatives",
    "canInterpolateInputs": "input derivatives",
    "maxOutputDerivativeOrder": "output derivatives",
}
_ARM64, _MACHO_64, _FAT = 0x0100000C, b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe"


def check_exportable(binding: Binding) -> None:
    """Raise where a container cannot hold the twin's FMUs.

    Raises
    ------
    ExportError
        A parameter is another text than its FMU's, or an FMU is not FMI 2.0, needs its own tool,
        or may be instantiated once only and is in the twin twice.
    """
    for name, text in binding.words.texts.items():
        if text != binding.variables[name].variable.start_text:
            raise ExportError(
                f"parameter '{name}' is a text, which the augmented FMU cannot hold; expected the "
                "FMU's own value, ask its vendor for an export with this one; the diagnosis holds "
                "without"
            )
    seen: dict[str, FmuDescription] = {}
    for fmu, content in zip(binding.fmus, binding.content, strict=True):
        if fmu.major != 2:
            raise ExportError(
                f"'{fmu.path.name}' is FMI {fmu.fmi_version}: expected FMI 2.0, which the "
                "augmented FMU is made of; ask its vendor for it, the diagnosis holds without"
            )
        if fmu.capabilities.get("needsExecutionTool"):
            raise ExportError(
                f"'{fmu.path.name}' needs the tool that made it: expected an FMU that runs by "
                "itself; ask its vendor for a stand-alone export, the diagnosis holds without"
            )
        if content in seen and fmu.capabilities.get("canBeInstantiatedOnlyOncePerProcess"):
            raise ExportError(
                f"'{fmu.path.name}' is in the twin twice and can be instantiated only once in the "
                "life of a process; one FMU cannot hold both, the diagnosis holds without"
            )
        seen[content] = fmu


def common_platforms(fmus: Sequence[FmuDescription]) -> tuple[Platform, ...]:
    """Platforms of the container for which every FMU has a library.

    Raises
    ------
    ExportError
        There is none; the message lists each FMU's platforms.
    """
    common = tuple(
        platform
        for platform in CONTAINER_PLATFORMS
        if all(library_for(fmu, platform) for fmu in fmus)
    )
    if not common:
        has = "; ".join(f"'{fmu.path.name}' has {', '.join(fmu.platforms)}" for fmu in fmus)
        names = ", ".join(platform.fmi_folders[0] for platform in CONTAINER_PLATFORMS)
        raise ExportError(
            f"no platform for the augmented FMU: expected binaries of every FMU for one of {names} "
            f"(on a Mac: arm64), {has}; ask the vendor for one of them, the diagnosis holds without"
        )
    return common


def library_for(fmu: FmuDescription, platform: Platform) -> PurePosixPath | None:
    """Archive member with the library for a platform; None where there is none."""
    try:
        member = fmu.library(platform)
    except FmuFileError:
        return None
    if platform.suffix == ".dylib":
        # The folder does not tell an Intel Mac's library from one for arm64.
        with open_archive(fmu.path) as archive, archive.open(member) as library:
            if not _is_for_arm64(library.read(4096)):
                return None
    return PurePosixPath(member.replace("\\", "/"))


def losses(binding: Binding, platforms: Sequence[Platform]) -> Iterator[str]:
    """List abilities of the FMUs that the container lacks."""
    for capability, words in _LOST.items():
        if any(fmu.capabilities.get(capability) for fmu in binding.fmus):
            yield f"{words} ({capability})"
    if any("model exchange" in fmu.kinds for fmu in binding.fmus):
        yield "model exchange"
    kept = {platform.fmi_folders[0] for platform in platforms}
    everywhere = set.intersection(*(set(fmu.platforms) for fmu in binding.fmus))
    if lost := sorted(everywhere - kept):
        yield f"binaries for {', '.join(lost)}"
    if "linux64" in kept:
        yield "Linux systems with a glibc older than 2.34"


def _is_for_arm64(head: bytes) -> bool:
    if head[:4] == _MACHO_64:
        return bool(struct.unpack_from("<I", head, 4)[0] == _ARM64)
    if head[:4] == _FAT:
        (count,) = struct.unpack_from(">I", head, 4)
        kinds = (struct.unpack_from(">I", head, 8 + 20 * k)[0] for k in range(min(count, 100)))
        return _ARM64 in kinds
    return False
