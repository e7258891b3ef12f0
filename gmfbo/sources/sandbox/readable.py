"""Files that a process running FMUs has to read: interpreter, libraries, devices."""

from __future__ import annotations

import importlib.util
import os
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path

from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.sandbox.landlock import OVERWRITE, READ, Access

_SYSTEM = (
    *("/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/opt", "/nix/store", "/gnu/store"),
    *("/etc/ld.so.cache", "/etc/ld.so.conf", "/etc/ld.so.conf.d", "/etc/ld.so.preload"),
    *("/etc/alternatives", "/etc/localtime", "/etc/timezone", "/etc/locale.alias"),
    *("/sys/devices/system/cpu", "/sys/devices/system/node", "/sys/fs/cgroup"),
    *("/proc/self", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat"),
    *("/proc/sys/kernel", "/proc/sys/vm", "/dev/urandom", "/dev/random"),
)
_DEVICES = ("/dev/null", "/dev/zero", "/dev/full")
_PACKAGES = ("numpy", "fmpy", "gmfbo")
_PACKAGE_FOLDERS = ("site-packages", "dist-packages")


def readable() -> dict[Path, Access]:
    """Files and folders with their rights; the user's own files are not among them."""
    allowed = {Path(name): READ for name in _SYSTEM}
    allowed |= {Path(name): OVERWRITE for name in _DEVICES}
    allowed |= dict.fromkeys(_of_python(), READ)
    allowed[models_folder() / "master"] = READ
    for name in os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep):
        if name:
            allowed[Path(name)] = READ
    return allowed


def _of_python() -> Iterator[Path]:
    """Standard library and packages, which may lie in the user's home."""
    paths = sysconfig.get_paths()
    for key in ("stdlib", "platstdlib", "purelib", "platlib"):
        yield Path(paths[key])
    # Shared libraries of the interpreter and of conda's packages.
    yield Path(sys.base_prefix) / "lib"
    yield Path(sys.prefix) / "lib"
    yield Path(sys.prefix) / "pyvenv.cfg"
    for name in sys.path:
        if Path(name).name in _PACKAGE_FOLDERS:  # those of `pip install --user` too
            yield Path(name)
    for name in _PACKAGES:
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.origin:
            # Libraries that belong to a wheel lie beside it: numpy.libs.
            folder = Path(spec.origin).parent
            yield folder
            yield folder.with_name(folder.name + ".libs")
