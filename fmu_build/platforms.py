"""Platforms that are built for, and their names in zig, in FMI and in `models/master/`."""

from __future__ import annotations

import platform
import sys
from dataclasses import dataclass

from fmu_build.failure import BuildError


@dataclass(frozen=True)
class Platform:
    """One target.

    Attributes
    ----------
    name : str
        Folder below models/master/.
    target : str
        Target triple of zig; glibc 2.17 runs on every Linux since 2014.
    suffix : str
        Of a shared library.
    fmi_folder : str
        Folder below binaries/ of an FMU. FMI 2.0 has none for Linux on ARM: that of FMI 3.0.
    fmi3_folder : str
        The same for FMI 3.0.
    """

    name: str
    target: str
    suffix: str
    fmi_folder: str
    fmi3_folder: str


PLATFORMS = {
    entry.name: entry
    for entry in (
        Platform("linux-x86_64", "x86_64-linux-gnu.2.17", ".so", "linux64", "x86_64-linux"),
        Platform(
            "linux-aarch64", "aarch64-linux-gnu.2.17", ".so", "aarch64-linux", "aarch64-linux"
        ),
        Platform("windows-x86_64", "x86_64-windows-gnu", ".dll", "win64", "x86_64-windows"),
        Platform("macos-x86_64", "x86_64-macos.11.0", ".dylib", "darwin64", "x86_64-darwin"),
        Platform("macos-aarch64", "aarch64-macos.11.0", ".dylib", "darwin64", "aarch64-darwin"),
    )
}

# For a test of what the driver says about an FMU that nobody here can run.
FOREIGN = Platform("linux-i386", "x86-linux-gnu.2.17", ".so", "linux32", "x86-linux")


def this_platform() -> Platform:
    """Platform of the running interpreter.

    Raises
    ------
    BuildError
        If it is none of `PLATFORMS`.
    """
    system = {"linux": "linux", "win32": "windows", "darwin": "macos"}.get(sys.platform, "")
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    try:
        return PLATFORMS[f"{system}-{machine}"]
    except KeyError:
        raise BuildError(
            f"no platform '{sys.platform}-{machine}'; known are {', '.join(PLATFORMS)}"
        ) from None
