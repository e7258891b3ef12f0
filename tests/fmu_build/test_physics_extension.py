"""The page on FMUs shows how an effect is added; this adds it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from fmu_build.build import SOURCES
from fmu_build.compile import find_compiler
from fmu_build.declaration import read_declaration
from fmu_build.fmu import build_fmu
from fmu_build.platforms import this_platform
from tests.fmu_build.fmu_instance import FmuInstance, unpacked_fmu


def test_the_effect_in_the_documentation_builds_and_acts(tmp_path: Path, zig_cache: Path) -> None:
    page = (SOURCES.parent / "notebooks" / "docs" / "fmus.md").read_text(encoding="utf-8")
    section = page.split("## Effects at the ports")[1]
    function, call = (block.split("```")[0] for block in section.split("```c\n")[1:])
    variable = section.split("```toml\n")[1].split("```")[0]

    folder, work = tmp_path / "physics", tmp_path / "work"
    shutil.copytree(SOURCES / "physics", folder)
    work.mkdir()
    insert(folder / "forces.h", function, before="#endif")
    insert(folder / "physics.c", call, before="    return torque;")
    with (folder / "model.toml").open("a", encoding="utf-8") as file:
        file.write("\n" + variable)

    compiler = find_compiler("zig", zig_cache, [this_platform()])
    path = tmp_path / "physics.fmu"
    declaration = read_declaration(folder / "model.toml")
    path.write_bytes(build_fmu(declaration, compiler, [this_platform()], work))
    with unpacked_fmu(path) as unpacked:
        effects = FmuInstance(unpacked).start(cubic_spring__stiffness=2.0, state__position=3.0)
        effects.step(0.0, 1e-3)
        assert effects.get("torque") == pytest.approx(-54.0, rel=1e-15)
        effects.close()


def insert(path: Path, text: str, before: str) -> None:
    """Insert text before the last occurrence of a line."""
    head, tail = path.read_text(encoding="utf-8").rsplit(before, 1)
    path.write_text(f"{head}{text}{before}{tail}", encoding="utf-8")
