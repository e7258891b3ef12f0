"""The page on the package's rooms names those there are, and files that import each other."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "notebooks/docs/where_things_are.md").read_text(encoding="utf-8")
WALKS = ("From a study file to the plant", "From a CSV file to the verdict")


def first_cells(heading: str) -> list[str]:
    """Code in the first column of the table below a heading."""
    section = PAGE.split(f"## {heading}\n")[1].split("\n## ")[0]
    return re.findall(r"^\| `([^`]+)` \|", section, re.MULTILINE)


def imported_files(path: Path) -> set[Path]:
    """Files that a module imports, wherever in its text it does."""
    names = imported_names(ast.parse(path.read_text(encoding="utf-8")))
    return {file for name in names if (file := module_file(name)) is not None}


def imported_names(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (one.name for one in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield node.module
            yield from (f"{node.module}.{one.name}" for one in node.names)


def module_file(name: str) -> Path | None:
    place = ROOT.joinpath(*name.split("."))
    candidates = (place.with_suffix(".py"), place / "__init__.py")
    return next((path for path in candidates if path.is_file()), None)


def test_rooms_stand_in_the_order_in_which_they_import() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = project["tool"]["importlinter"]["contracts"]
    (order,) = (one["layers"] for one in contracts if one["name"] == "Imports point one way")
    assert first_cells("Rooms") == [room for layer in order for room in layer.split(" | ")]


@pytest.mark.parametrize("walk", WALKS)
def test_files_of_a_walk_exist_and_each_imports_the_next(walk: str) -> None:
    files = [ROOT / name for name in first_cells(walk)]
    assert 5 < len(files) <= 10
    assert all(file.is_file() for file in files)
    gaps = [(one.name, other.name) for one, other in pairwise(files) if not_imported(one, other)]
    assert not gaps


def not_imported(one: Path, other: Path) -> bool:
    return other not in imported_files(one)


@pytest.mark.parametrize("walk", WALKS)
def test_control_a_walk_backwards_is_no_walk(walk: str) -> None:
    files = [ROOT / name for name in reversed(first_cells(walk))]
    assert all(not_imported(one, other) for one, other in pairwise(files))


def test_every_file_that_the_page_names_exists() -> None:
    named = re.findall(r"`(gmfbo/[\w/.]+|tests/[\w/.]+)`", PAGE)
    assert len(named) > 20
    assert all((ROOT / name).exists() for name in named if name != "gmfbo/")
