"""A parameter that the twin file holds fixed, freed beside a named effect, is told as such."""

from __future__ import annotations

import re
from dataclasses import replace
from html import unescape

from gmfbo.cli.diagnosis.diagnosis_screen import screenful
from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.page.page import diagnosis_page
from gmfbo.diagnosis.result.estimated import EstimatedParameter
from tests.diagnosis.example_diagnoses import friction, outside, parameters

FREED = EstimatedParameter(
    0.2, 0.1213, "kg.m2", 0.1192, 0.1231, stated="ax7.toml, line 14", fixed=True
)


def beside_friction(inertia: EstimatedParameter) -> Diagnosis:
    """Friction is missing, and the inertia has another value than the twin."""
    return replace(friction(), parameters={"mech.J": inertia})


def page_text(diagnosis: Diagnosis) -> str:
    page = re.sub(r"<(script|style).*?</\1>", "", diagnosis_page(diagnosis), flags=re.DOTALL)
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", page)).split())


def test_the_terminal_and_the_table_say_where_a_freed_parameter_is_fixed() -> None:
    made = beside_friction(FREED)
    terminal = " ".join(" ".join(screenful(made)).split())
    assert "mech.J 0.2 -> 0.121 [0.119, 0.123] kg m2 (fixed in ax7.toml, line 14)" in terminal
    assert "(fixed in ax7.toml, line 14)" in page_text(made).partition("The twin's own values")[2]


def test_the_first_screen_of_the_report_tells_a_freed_parameter_beside_an_effect() -> None:
    first = page_text(beside_friction(FREED)).partition("The twin's own values")[0]
    assert (
        "mech.J = 0.1213 [ 0.1192 , 0.1231 ] kg m², in the twin 0.2 (fixed in ax7.toml, line 14)"
        in first
    )


def test_a_freed_parameter_that_stands_alone_is_told_once_with_its_place() -> None:
    alone = page_text(replace(parameters(), parameters={"mech.J": FREED}))
    first = alone.partition("The twin's own values")[0]
    assert first.count("in the twin 0.2 (fixed in ax7.toml, line 14)") == 1


def test_control_an_uncertain_parameter_is_never_called_fixed() -> None:
    made = beside_friction(replace(FREED, fixed=False, stated=""))
    assert "fixed in" not in " ".join(screenful(made))
    assert "fixed in" not in page_text(made)
    assert "in the twin 0.2" not in page_text(made).partition("The twin's own values")[0]


def test_a_fixed_parameter_that_is_not_sure_is_no_fact() -> None:
    unsure = replace(parameters(), parameters={"mech.J": replace(FREED, probability=0.62)})
    assert unsure.sentence.startswith("The twin's values may explain the difference: mech.J may be")
    assert "parameters may explain it" in page_text(unsure)
    sure = replace(parameters(), parameters={"mech.J": replace(FREED, probability=0.9)})
    assert sure.sentence.startswith("The twin's values explain the difference: mech.J is 0.121")


def test_a_freed_parameter_is_told_beside_what_nothing_explains() -> None:
    told = replace(outside(), parameters={"mech.J": FREED}).sentence
    assert "Something is missing" in told
    assert "mech.J is 0.121 kg m2 instead of 0.2 (fixed in ax7.toml, line 14)." in told
