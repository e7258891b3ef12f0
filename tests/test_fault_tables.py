"""The tables of notebooks/docs/faults.md: each row names a test, and that test is there."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from fmu_build.fault_fmus import read_faults
from tests.sources.sandbox.test_sandbox import ALLOWED, REFUSED
from tests.sources.worker.test_fault_fmus import GETS

TESTS = Path(__file__).resolve().parent
PAGE = TESTS.parent / "notebooks/docs/faults.md"
TEXT = PAGE.read_text(encoding="utf-8")
NAMED = sorted(set(re.findall(r"`(\w+/test_\w+\.py::test_\w+(?:\[\w+\])?)`", TEXT)))
PARAMETERS = {*GETS, *REFUSED, *ALLOWED}


@cache
def functions(file: str) -> dict[str, ast.FunctionDef]:
    tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("named", NAMED)
def test_a_named_test_exists_and_asserts(named: str) -> None:
    file, _, rest = named.partition("::")
    name, _, case = rest.rstrip("]").partition("[")
    found = functions(file)[name]
    asserted = [node for node in ast.walk(found) if isinstance(node, ast.Assert)]
    raised = "pytest.raises" in ast.unparse(found) or "pytest.warns" in ast.unparse(found)
    assert asserted or raised
    assert not case or (case in PARAMETERS and "parametrize" in ast.unparse(found))


def test_each_row_names_a_test() -> None:
    tables = re.findall(r"^\|[^\n]* test \|\n\|[-|]+\n((?:\|[^\n]*\n)+)", TEXT, re.MULTILINE)
    assert len(tables) == 3
    for row in "".join(tables).splitlines():
        assert re.search(r"`(?:\w+/)+test_\w+\.py::test_\w+(\[\w+\])?` \|$", row), row


def test_each_fault_fmu_has_one_row() -> None:
    told = re.findall(r"^\| `(\w+)` \|", TEXT.split("## Faults")[1], re.MULTILINE)
    assert sorted(told) == sorted(fault.name for fault in read_faults())
