"""Names of this machine's platform, in FMUs and for the C master."""

from __future__ import annotations

import platform
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path

from gmfbo.sources.fmu_file.models import models_folder

_SYSTEMS = {"linux": "linux", "win32": "windows", "darwin": "macos"}
_MACHINES = {"amd64": "x86_64", "x64": "x86_64", "arm64": "aarch64"}
_SUFFIXES = {"linux": ".so", "windows": ".dll", "macos": ".dylib"}

# FMI 2.0 names no folder for Linux on ARM; exporters use that of FMI 3.0.
_FMI_FOLDERS = {
    "linux-x86_64": ("linux64", "x86_64-linux"),
    "linux-aarch64": ("aarch64-linux",),
    "windows-x86_64": ("win64", "x86_64-windows"),
    "macos-x86_64": ("darwin64", "x86_64-darwin"),
    "macos-aarch64": ("darwin64", "aarch64-darwin"),
}


@dataclass(frozen=True)
class Platform:
    """One system and processor.

    Attributes
    ----------
    name : str
        Folder of the C master, such as `linux-x86_64`.
    fmi_folders : tuple of str
        Folders below `binaries/` of an FMU that can hold a library for it, best first.
    suffix : str
        Of a shared library.
    """

    name: str
    fmi_folders: tuple[str, ...]
    suffix: str


def this_platform() -> Platform:
    """Platform of the running interpreter; of an unknown one by the rule of FMI 3.0."""
    system = _SYSTEMS.get(sys.platform, sys.platform)
    machine = platform.machine().lower()
    machine = _MACHINES.get(machine, machine)
    if sys.maxsize <= 2**32:
        machine = "x86"
    name = f"{system}-{machine}"
    return Platform(
        name=name,
        fmi_folders=_FMI_FOLDERS.get(name, (f"{machine}-{system}",)),
        suffix=_SUFFIXES.get(system, ".so"),
    )


def master_path() -> Path | None:
    """Library of the C master for this machine; None where the project builds none."""
    here = this_platform()
    path = models_folder() / "master" / here.name / f"gmfbo_master{here.suffix}"
    return path if path.is_file() else None


def warn_without_master(stacklevel: int) -> None:
    """Warn where the project builds no C master for this machine.

    Parameters
    ----------
    stacklevel : int
        As of `warnings.warn`, counted from the caller.
    """
    if master_path() is None:
        warnings.warn(
            f"no C master for {this_platform().name}: FMUs are stepped in Python, about four "
            "times slower",
            RuntimeWarning,
            stacklevel=stacklevel + 1,
        )
