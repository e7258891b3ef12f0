"""A column that is off by more than usual is told beside the law that would explain the same."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from gmfbo.cli.diagnosis.diagnosis_screen import screenful
from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.page.page import diagnosis_page
from gmfbo.diagnosis.result.estimated import Alignment
from gmfbo.diagnosis.result.misaligned_columns import misaligned_sentence
from tests.diagnosis.example_diagnoses import friction, late, nothing, parameters

SAID = (
    "Either torque command was logged 2.9 ms early, which is more than usual, or transport delay "
    "is missing from the twin: that explains the recordings as well."
)


def test_both_are_told_in_terminal_prompt_notebook_and_report() -> None:
    page = re.sub(r"<[^>]+>", "", diagnosis_page(late())).replace("\xa0", " ")
    assert SAID in " ".join(" ".join(screenful(late())).split())
    assert SAID in repr(late())
    assert SAID in late()._repr_html_()
    assert page.count(SAID) == 2, "on the first screen and beside the table"


def test_an_alignment_without_a_rival_is_no_sentence() -> None:
    """Negative control."""
    far = Alignment("held", 3e-3, 1.0, 0.0, None, {"shift": 28.6})
    for column in (friction().alignment["torque_command"], far):
        made = replace(friction(), alignment={"torque_command": column})
        assert misaligned_sentence(made) == ""
        assert "Either" not in diagnosis_page(made)
        assert "Either" not in "\n".join(screenful(made))


@pytest.mark.parametrize(
    ("column", "said"),
    [
        (Alignment("held", 1e-3, 1.0, 0.0, "sensor_lag", {"shift": 9.0}), "1 ms late"),
        (Alignment("held", 0.0, 1.15, 0.0, "x", {"scale": 7.0}), "15 % too large"),
        (Alignment("held", 0.0, 0.9, 0.0, "x", {"scale": 7.0}), "10 % too small"),
        (Alignment("held", 0.0, 1.0, -0.3, "x", {"offset": 8.0}), "0.3 N m too low"),
        (Alignment("held", 1.0, 1.0, 0.3, "x", {"offset": 8.0, "shift": 7.0}), "0.3 N m too high"),
    ],
)
def test_what_is_off_by_most_is_named_with_its_size(column: Alignment, said: str) -> None:
    made = replace(friction(), alignment={"torque_command": column})
    assert f"torque command was logged {said}, " in misaligned_sentence(made)


def test_two_columns_with_one_rival_are_one_sentence() -> None:
    one = late().alignment["torque_command"]
    made = replace(late(), alignment={"position": one, "torque_command": one})
    assert misaligned_sentence(made).count("Either") == 1
    assert "position was logged 2.9 ms early and torque command" in misaligned_sentence(made)


@pytest.mark.parametrize("found", [nothing(), parameters()])
def test_a_late_column_is_told_where_no_physics_is(found: Diagnosis) -> None:
    far = Alignment("held", 3e-3, 1.0, 0.0, None, {"shift": 28.6})
    told = "Position was logged 3 ms late, which is more than usual: correct that column"
    made = replace(found, alignment={"position": far})
    assert told in misaligned_sentence(made)
    assert told in " ".join(" ".join(screenful(made)).split())
    within = replace(far, beyond_prior={})
    assert misaligned_sentence(replace(found, alignment={"position": within})) == ""
