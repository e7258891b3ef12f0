"""No module of the package is found by its name as a text, but for the documented tables."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TABLES = {"gmfbo/__init__.py", "gmfbo/tuning/methods/__init__.py", "gmfbo/retuning/__init__.py"}
"""The lazy public names, and the rows of the table of methods."""

NAME = re.compile(r"(gmfbo(?:\.\w+)+)(?::\w+)?")


def texts(source: str) -> Iterator[str]:
    """Each text in a program that is not a docstring, formatted ones by their parts."""
    tree = ast.parse(source)
    told = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in told:
            yield node.value


def modules_named(source: str) -> set[str]:
    """Modules of the package that a program names in a text that is nothing but the name."""
    found = (NAME.fullmatch(text) for text in texts(source))
    return {match[1] for match in found if match and find_spec(match[1]) is not None}


def test_modules_are_named_as_texts_in_tables_alone() -> None:
    found = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "gmfbo").rglob("*.py")
        if modules_named(path.read_text(encoding="utf-8"))
    }
    assert found == TABLES


def test_control_a_module_named_as_a_text_is_seen() -> None:
    assert modules_named('"""gmfbo.space"""\nPAGE = "gmfbo.space:GainSpace"\n') == {"gmfbo.space"}
    assert not modules_named('GROUP = "gmfbo.methods"\n')
