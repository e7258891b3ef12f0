"""README's promises that a test can hold it to."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_constraints_hold_an_exact_version_of_every_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = [*project["dependencies"], *project["optional-dependencies"]["tests"]]
    pinned = {
        line.partition("==")[0].lower().replace("_", "-")
        for line in (ROOT / "tests/constraints.txt").read_text().splitlines()
        if "==" in line
    }
    names = {re.split(r"[<>=;\s\[]", text)[0].lower() for text in wanted}
    assert names <= pinned, names - pinned


def test_torch_is_pinned_to_the_tested_build() -> None:
    assert "torch==2.13.0" in (ROOT / "tests/constraints.txt").read_text().splitlines()


def test_readme_marks_one_demo_and_one_test_command() -> None:
    text = (ROOT / "README.md").read_text()
    for mark in ("demo", "test"):
        block = re.search(rf"<!-- {mark} command -->\n```\n(.+)\n```\n<!-- end -->", text)
        assert block is not None
        assert "-c tests/constraints.txt" in block.group(1)
