"""One C compiler call for each platform, through the ziglang package or the system's compiler."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from fmu_build.failure import BuildError
from fmu_build.platforms import Platform, this_platform

CompilerName = Literal["zig", "system"]

# No contraction to fused multiply-add: results must not depend on the processor.
_FLAGS = ("-std=c11", "-O2", "-g0", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off")
_WARNINGS = ("-Wall", "-Wextra", "-Werror")


@dataclass(frozen=True)
class Compiler:
    """Compiles shared libraries.

    Attributes
    ----------
    command : tuple of str
        How it is called.
    cache : Path or None
        Folder for zig's copies of the system libraries; None for a system compiler.
    """

    command: tuple[str, ...]
    cache: Path | None

    def shared_library(
        self, folder: Path, sources: Sequence[str], library: str, target: Platform
    ) -> bytes:
        """Compile and link in `folder`, with relative names only: paths would enter the result.

        Parameters
        ----------
        folder : Path
            Working directory.
        sources : sequence of str
            C files relative to `folder`.
        library : str
            File name of the result, without suffix.
        target : Platform
            Where it will run.

        Returns
        -------
        bytes
            Contents of the library.

        Raises
        ------
        BuildError
            With the compiler's own words.
        """
        result = library + target.suffix
        command = [*self.command, *_FLAGS, *_WARNINGS, "-I.", "-shared", "-o", result, *sources]
        command += self._target_flags(target, result)
        environment = dict(os.environ)
        if self.cache is not None:
            environment |= {
                "ZIG_GLOBAL_CACHE_DIR": str(self.cache),
                "ZIG_LOCAL_CACHE_DIR": str(folder / ".zig-cache"),
            }
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        if done.returncode != 0:
            raise BuildError(
                f"{library} for {target.name} does not compile:\n{done.stderr.strip()}"
            )
        return (folder / result).read_bytes()

    def _target_flags(self, target: Platform, result: str) -> list[str]:
        flags = []
        if self.cache is not None:
            # zig would else link its run-time checks for undefined behaviour.
            flags += ["-target", target.target, "-fno-sanitize=undefined"]
        if target.suffix == ".dylib":
            flags += [f"-Wl,-install_name,@rpath/{result}"]
        else:
            flags += ["-s"]  # symbol tables hold a time on Windows
        if target.suffix == ".so":
            flags += ["-lm"]
        return flags


def find_compiler(name: CompilerName, cache: Path, targets: Sequence[Platform]) -> Compiler:
    """Compiler for these targets.

    Raises
    ------
    BuildError
        If it is not installed, or cannot build for another machine than this.
    """
    if name == "zig":
        if importlib.util.find_spec("ziglang") is None:
            raise BuildError('the package ziglang is missing: pip install "gmfbo[build]"')
        return Compiler((sys.executable, "-m", "ziglang", "cc"), cache)
    found = os.environ.get("CC") or next(filter(shutil.which, ("cc", "gcc", "clang")), None)
    if found is None:
        raise BuildError("no system compiler: set CC, or build with --compiler zig")
    foreign = [target.name for target in targets if target != this_platform()]
    if foreign:
        raise BuildError(f"the system compiler cannot build for {foreign[0]}: use --compiler zig")
    return Compiler(tuple(found.split()), None)
