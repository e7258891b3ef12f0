"""notebooks/docs/conventions.md: each convention names the test that shows it, and it is there."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "notebooks/docs/conventions.md").read_text(encoding="utf-8")
TABLES = re.findall(
    r"^\| convention \| shown by \|\n\|[-|]+\n((?:\|[^\n]*\n)+)", TEXT, re.MULTILINE
)
ROWS = "".join(TABLES).splitlines()


@pytest.mark.parametrize("row", ROWS)
def test_a_convention_names_a_test_or_a_file_that_is_there(row: str) -> None:
    named = re.search(r"\| `([\w./]+?)(?:::(test_\w+))?` \|$", row)
    assert named is not None, row
    file, test = named.groups()
    if test is None:
        assert (ROOT / file).is_file()
    else:
        tree = ast.parse((ROOT / "tests" / file).read_text(encoding="utf-8"))
        assert test in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_most_conventions_are_shown_by_a_test() -> None:
    assert len(ROWS) > 40
    assert sum("::test_" in row for row in ROWS) > 0.8 * len(ROWS)


def test_readme_leads_to_the_conventions() -> None:
    assert "(notebooks/docs/conventions.md)" in (ROOT / "README.md").read_text(encoding="utf-8")
