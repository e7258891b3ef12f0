"""What the page on reports tells a user to write works, and what it names is there."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

from tests.reports.study.example_studies import write_example_study

PAGE = Path(__file__).resolve().parents[2] / "notebooks/docs/reports.md"
TEXT = PAGE.read_text(encoding="utf-8")


def test_the_figures_on_the_page_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    write_example_study(tmp_path, name="joint")
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    exec(code, {})
    assert (tmp_path / "best_run.pdf").read_bytes().startswith(b"%PDF")
    assert "<svg" in (tmp_path / "trust.svg").read_text(encoding="utf-8")


def test_every_function_on_the_page_is_there() -> None:
    rows = re.findall(r"^\| a \w+: `([\w.]+)` \| (.*) \|$", TEXT, re.MULTILINE)
    assert len(rows) == 4
    for module, functions in rows:
        names = re.findall(r"`(\w+)`", functions)
        assert names
        assert all(callable(getattr(importlib.import_module(module), name)) for name in names)
