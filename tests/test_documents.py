"""What the documents say of the catalogue and of a run is what the package does."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from gmfbo import diagnose
from tests.effect_table import documented_table, effect_table

ROOT = Path(__file__).resolve().parents[1]


def test_documented_table_of_effects_is_that_of_the_catalogue() -> None:
    assert documented_table() == effect_table(), "run python -m tests.effect_table"


def test_example_of_the_readme_finds_what_it_prints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    script = re.search(r"```python\n(import numpy.*?)```", text, re.DOTALL)
    assert script is not None
    printed = re.search(r"^missing +(.+), probability", text, re.MULTILINE)
    assert printed is not None
    (tmp_path / "models").symlink_to(ROOT / "models")
    monkeypatch.chdir(tmp_path)
    exec(script.group(1), {})
    found = diagnose("models/servo_axis.toml", sorted(tmp_path.glob("run*.csv")))
    (effect,) = found.effects
    assert effect.name.replace("_", " ") == printed.group(1)
    assert effect.parameters["level"].value == pytest.approx(0.2, rel=0.02)
    error = found.fit.signals["torque_command"]
    assert error.augmented < 0.2 * error.parameters_only
