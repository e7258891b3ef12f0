"""A physics.fmu with the law of an effect that is not part of the project."""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

from fmu_build.compile import find_compiler
from fmu_build.declaration import read_declaration
from fmu_build.failure import BuildError
from fmu_build.fmu import build_fmu
from fmu_build.platforms import Platform, this_platform

PHYSICS = Path(__file__).resolve().parent / "physics"
# Where a call goes: before the sum of all effects at that port is returned.
_LAST_LINES = {"torque": "    return torque;", "sensor": "    return reading;"}
_SUMS = {"torque": "torque", "sensor": "reading"}


def build_physics(
    output: Path,
    name: str,
    law: str,
    parameters: Mapping[str, str],
    *,
    port: Literal["torque", "sensor"] = "torque",
    platforms: Sequence[Platform] = (),
) -> Path:
    """Build physics.fmu with one more law; it takes the place of ours by `GMFBO_PHYSICS`.

    Parameters
    ----------
    output : Path
        File to write.
    name : str
        Of the effect and of its C function.
    law : str
        C: `static inline double NAME(const double *v, const Signals *s)` gives what is added at
        the port; the parameter p is `v[V_NAME_p]`, zero where the effect is off.
    parameters : mapping of str to str
        What each parameter is, by its name.
    port : {"torque", "sensor"}
        Where it acts. A law that remembers, or one of the chain that the command runs through,
        needs changes in `fmu_build/physics/` itself.
    platforms : sequence of Platform
        Where it shall run; on this machine unless given.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    BuildError
        The name is taken or no C name, or the law does not compile.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise BuildError(f"expected a name of small letters, digits and '_', got '{name}'")
    with tempfile.TemporaryDirectory(prefix="gmfbo-build-") as place:
        folder, work = Path(place) / "physics", Path(place) / "work"
        shutil.copytree(PHYSICS, folder)
        work.mkdir()
        _add(folder, name, law, parameters, port)
        cache = Path(os.environ.get("ZIG_GLOBAL_CACHE_DIR", Path(place) / "cache"))
        targets = list(platforms) or [this_platform()]
        chosen = find_compiler("zig", cache, targets)
        built = build_fmu(read_declaration(folder / "model.toml"), chosen, targets, work)
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_bytes(built)
    return output


def _add(folder: Path, name: str, law: str, parameters: Mapping[str, str], port: str) -> None:
    """Put law, call and parameters into a copy of the sources."""
    declared = read_declaration(folder / "model.toml")
    if any(variable.name.startswith(f"{name}.") for variable in declared.variables):
        raise BuildError(f"physics.fmu has an effect '{name}'; give yours another name")
    _insert(folder / "physics.c", f"{law.strip()}\n\n", before="static double torque_effects")
    call = f"    {_SUMS[port]} += {name}(v, s);\n"
    _insert(folder / "physics.c", call, before=_LAST_LINES[port])
    with (folder / "model.toml").open("a", encoding="utf-8") as file:
        for parameter, description in parameters.items():
            file.write(
                f'\n[[variable]]\nname = "{name}.{parameter}"\ncausality = "parameter"\n'
                f"tunable = true\ndescription = {json.dumps(description)}\n"
            )


def _insert(path: Path, text: str, before: str) -> None:
    head, tail = path.read_text(encoding="utf-8").rsplit(before, 1)
    path.write_text(f"{head}{text}{before}{tail}", encoding="utf-8")
