"""What the documents say of the catalogue and of a run is what the package does."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from gmfbo.diagnosis.comparison import numbers
from gmfbo.physics import Effect, States, Units
from gmfbo.physics.example_axis import EXAMPLE_AXIS
from gmfbo.tuning.methods import METHODS
from gmfbo.version import __version__
from tests.effect_table import documented_table, effect_table
from tests.readme_blocks import Typed, difference, type_in

ROOT = Path(__file__).resolve().parents[1]


def test_documented_table_of_effects_is_that_of_the_catalogue() -> None:
    assert documented_table() == effect_table(), "run python -m tests.effect_table"


def documented_numbers(page: str) -> dict[str, tuple[float, ...]]:
    """Values in the table of a page, by name."""
    table = page.partition("<!-- numbers -->\n")[2].partition("<!-- end of numbers -->")[0]
    rows = re.findall(r"^\| `(\w+)` \| (-?\d[\d.]*(?:, -?\d[\d.]*)*)", table, re.MULTILINE)
    return {name: tuple(map(float, values.split(", "))) for name, values in rows}


def numbers_in_force() -> dict[str, tuple[float, ...]]:
    return {
        name: value if isinstance(value, tuple) else (float(value),)
        for name, value in vars(numbers).items()
        if name.isupper()
    }


def test_documented_numbers_are_those_that_decide() -> None:
    page = (ROOT / "notebooks/docs/diagnosis_decision.md").read_text(encoding="utf-8")
    assert documented_numbers(page) == numbers_in_force()


def test_control_a_changed_number_is_noticed() -> None:
    page = (ROOT / "notebooks/docs/diagnosis_decision.md").read_text(encoding="utf-8")
    changed = page.replace("| `NAMED` | 0.95 |", "| `NAMED` | 0.9 |")
    assert documented_numbers(changed) != numbers_in_force()


@pytest.mark.parametrize(
    ("name", "most"),
    [
        ("diagnosis", 1100),
        ("diagnosis_decision", 3000),
        ("sources", 600),
        ("mismatch", 600),
        ("verdict", 600),
        ("cannot_know", 600),
    ],
)
def test_pages_that_explain_stay_short(name: str, most: int) -> None:
    page = (ROOT / f"notebooks/docs/{name}.md").read_text(encoding="utf-8")
    assert len(page.split()) <= most


def test_documented_effect_is_one() -> None:
    page = (ROOT / "notebooks/docs/own_effect.md").read_text(encoding="utf-8")
    names: dict[str, object] = {}
    exec(page.split("```python\n")[1].split("```")[0], names)
    effect = names["cubic_spring"]
    assert isinstance(effect, Effect)
    (start,) = effect.starts(EXAMPLE_AXIS)
    low, high = effect.bounds(EXAMPLE_AXIS)["stiffness"]
    assert low < start["stiffness"] < high
    assert effect.size(start, EXAMPLE_AXIS) > effect.floor(EXAMPLE_AXIS)
    time, position = np.arange(4.0), np.array([0.0, 1.0, 2.0, -3.0])
    still = np.zeros(4)
    states = States(time, position, velocity=still, command=still, current=still, rest=0.1)
    assert effect.signal is not None
    np.testing.assert_array_equal(
        effect.signal(states, {"stiffness": 2.0}), [0.0, -2.0, -16.0, 54.0]
    )
    np.testing.assert_array_equal(effect.acts(states, start), [False, False, True, True])
    said = effect.statement({"stiffness": 2.0}, Units(), "at the motor shaft")
    assert said == "A spring of about 2 N m/rad3 at the motor shaft is missing from the twin."


@pytest.mark.slow
def test_the_worked_example_prints_what_its_page_says(tmp_path: Path) -> None:
    page = (ROOT / "notebooks/docs/diagnosis.md").read_text(encoding="utf-8")
    command = "gmfbo diagnose servo_axis.toml run*.csv --out found\n"
    promised = page.partition(f"$ {command}")[2].partition("\n```")[0]
    promised = re.sub(r"^cost .*", "...", promised, flags=re.MULTILINE)  # seconds of a machine
    assert "coulomb friction" in promised
    blocks = [Typed(". .venv/bin/activate\ngmfbo examples tour\ncd tour\n", ""), Typed(command, "")]
    _, printed = type_in(blocks, tmp_path)
    assert not difference(promised, printed)


def test_changelog_has_an_entry_for_this_version() -> None:
    page = (ROOT / "notebooks/docs/changelog.md").read_text(encoding="utf-8")
    release = __version__.partition(".dev")[0]
    assert re.search(rf"^## {re.escape(release)}( |$)", page, re.MULTILINE)


def test_cited_paper_is_the_one_that_the_printed_method_names() -> None:
    page = (ROOT / "notebooks/docs/citing.md").read_text(encoding="utf-8")
    cited = re.search(r"eprint += \{([\d.]+)\}", page)
    assert cited is not None
    assert f"arXiv:{cited.group(1)}" in METHODS["gmfbo_paper"].reference
