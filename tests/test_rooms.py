"""Each room of the package tells its story, and every name in that story exists."""

from __future__ import annotations

import ast
import re
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

import gmfbo

PACKAGE = Path(gmfbo.__file__).parent
ROOMS = sorted(
    ".".join(("gmfbo", *init.parent.relative_to(PACKAGE).parts))
    for init in PACKAGE.rglob("__init__.py")
)
DOTTED = re.compile(r"`([a-z_]\w*\.[A-Za-z_]\w*)`")
FILES = ("physics.fmu", "pyproject.toml")


def story(room: str) -> str:
    """Docstring of a room, read without importing it."""
    text = PACKAGE.joinpath(*room.split(".")[1:], "__init__.py").read_text(encoding="utf-8")
    return ast.get_docstring(ast.parse(text)) or ""


def exists(room: str, name: str) -> bool:
    """Whether `module.name` is an attribute of a module, or a module of a room."""
    module, attribute = name.split(".")
    if find_spec(f"{room}.{module}") is None:
        return False
    found = import_module(f"{room}.{module}")
    return hasattr(found, attribute) or (
        hasattr(found, "__path__") and find_spec(f"{room}.{name}") is not None
    )


def test_every_folder_with_python_files_is_a_room() -> None:
    folders = {path.parent for path in PACKAGE.rglob("*.py")}
    assert sorted(folder.name for folder in folders if not (folder / "__init__.py").exists()) == []


@pytest.mark.parametrize("room", ROOMS)
def test_each_room_tells_what_it_is_for_in_two_to_eight_lines(room: str) -> None:
    lines = [line for line in story(room).splitlines() if line and line[0] != " "]  # no examples
    assert 2 <= len(lines) <= 8
    assert lines[0].endswith(".")
    assert len(lines[0]) <= 80


@pytest.mark.parametrize("room", ROOMS)
def test_every_name_in_the_story_of_a_room_exists(room: str) -> None:
    names = [name for name in DOTTED.findall(story(room)) if name not in FILES]
    assert [name for name in names if not exists(room, name)] == []
