"""The page on the twin file names each key there is, and its example is a twin file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import pytest
from pydantic import BaseModel

from gmfbo.sources.twin_file.column_file import ColumnEntry
from gmfbo.sources.twin_file.twin_file import KNOWN_STATES, TwinFile

PAGE = Path(__file__).resolve().parents[1] / "notebooks/docs/twin_file.md"
TEXT = PAGE.read_text(encoding="utf-8")

INTERNAL = {"words"}
"""Not written by anybody: texts of [parameters] are kept apart by it."""


def models_in(kind: object) -> list[type[BaseModel]]:
    """Tables that a type annotation holds."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return [kind]
    return [model for part in get_args(kind) for model in models_in(part)]


def keys() -> set[str]:
    """Keys of the twin file and of its tables."""
    found: set[str] = set()
    waiting: list[type[BaseModel]] = [TwinFile, ColumnEntry]
    while waiting:
        model = waiting.pop()
        found |= set(model.model_fields)
        for field in model.model_fields.values():
            waiting += [one for one in models_in(field.annotation) if one is not model]
    return found - INTERNAL


@pytest.mark.parametrize("key", sorted(keys()))
def test_each_key_stands_on_the_page(key: str) -> None:
    assert re.search(rf"`[^`]*\b{key}\b[^`]*`", TEXT)


def test_each_state_stands_on_the_page() -> None:
    (line,) = [line for line in TEXT.splitlines() if line.startswith("| `[states]`")]
    assert re.findall(r"`(\w+)`", line) == list(KNOWN_STATES)


def test_the_example_is_a_twin_file_of_the_shipped_fmu() -> None:
    (example,) = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
    twin = TwinFile.parse(example, "page")
    assert twin.outputs["torque_command"].logged == "held"
    assert twin.fixed.names == ["filter_time"]
