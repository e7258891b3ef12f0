"""What is told beside the values: parameters that drift, and a fit that was stopped."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.cli.diagnosis.diagnosis_screen import screenful
from gmfbo.diagnosis import Diagnosis
from gmfbo.diagnosis.page.page import diagnosis_page
from gmfbo.diagnosis.result.cautions import NOT_CONVERGED, drifts_words
from tests.diagnosis.example_diagnoses import friction, parameters, remaining, too_narrow

FINITE = st.floats(allow_nan=False, allow_infinity=False)


def drifting(*values: float) -> Diagnosis:
    """An inertia with one value in each recording: a.csv, b.csv and so on."""
    inertia = replace(
        friction().parameters["mech.J"],
        drifts={f"{chr(ord('a') + place)}.csv": value for place, value in enumerate(values)},
    )
    return replace(friction(), parameters={"mech.J": inertia})


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ((1.0, 1.4), "rises from 1 kg m2 in a.csv to 1.4 kg m2 in b.csv"),
        ((1.0, 1.0, 1.4), "rises from 1 kg m2 in a.csv to 1.4 kg m2 in c.csv"),
        ((1.4, 1.2, 1.0), "falls from 1.4 kg m2 in a.csv to 1 kg m2 in c.csv"),
        ((-0.1, -0.2), "falls from -0.1 kg m2 in a.csv to -0.2 kg m2 in b.csv"),
        ((0.0, 0.3), "rises from 0 kg m2 in a.csv to 0.3 kg m2 in b.csv"),
        ((1.0, 1.4, 1.0), "varies between 1 kg m2 in a.csv and 1.4 kg m2 in b.csv"),
        (
            (0.0, -1.0, 1.0),
            "varies between -1 kg m2 in b.csv and 1 kg m2 in c.csv",
        ),
    ],
)
def test_a_drift_is_told_by_its_ends_and_a_direction_only_where_it_has_one(
    values: tuple[float, ...], told: str
) -> None:
    assert drifts_words(drifting(*values)) == f"mech.J {told}."


@given(st.lists(FINITE, min_size=1, max_size=6))
def test_any_finite_values_are_told_and_a_direction_is_that_of_every_step(
    values: list[float],
) -> None:
    told = drifts_words(drifting(*values))
    steps = list(pairwise(values))
    rises = any(a < b for a, b in steps) and all(a <= b for a, b in steps)
    falls = any(a > b for a, b in steps) and all(a >= b for a, b in steps)
    assert ("rises" in told) == rises
    assert ("falls" in told) == falls
    assert "%" not in told


def test_control_parameters_that_do_not_drift_are_not_told() -> None:
    assert drifts_words(friction()) == ""
    assert drifts_words(remaining()).startswith("mech.J falls")


def shown_everywhere(diagnosis: Diagnosis) -> dict[str, str]:
    """Terminal, prompt, notebook and report, each as one line of text."""
    shown = {
        "terminal": "\n".join(screenful(diagnosis)),
        "prompt": repr(diagnosis),
        "notebook": re.sub(r"<[^>]+>", " ", diagnosis._repr_html_()),
        "report": re.sub(
            r"<(script|style).*?</\1>|<[^>]+>", " ", diagnosis_page(diagnosis), flags=re.S
        ),
    }
    return {where: " ".join(text.replace("\xa0", " ").split()) for where, text in shown.items()}


@pytest.mark.parametrize("where", ["terminal", "prompt", "notebook", "report"])
def test_a_stopped_fit_a_drift_and_errors_without_correction_are_told_wherever_one_looks(
    where: str,
) -> None:
    shown = shown_everywhere(replace(remaining(), converged=False))[where]
    assert NOT_CONVERGED in shown
    assert drifts_words(remaining()) in shown
    if where == "report":  # which has signals as columns
        assert "augmented twin, whole and uncorrected 2.1 %" in shown
    else:
        assert "whole, uncorrected 41 % 32 % 2.1 %" in shown


@pytest.mark.parametrize("where", ["prompt", "notebook"])
def test_control_a_fit_that_converged_of_a_steady_axis_has_no_caution(where: str) -> None:
    shown = shown_everywhere(parameters())[where]
    assert NOT_CONVERGED not in shown
    assert "mech.J falls" not in shown
    assert "uncorrected" not in shown


@pytest.mark.parametrize("where", ["prompt", "notebook"])
def test_what_the_sentence_says_of_ranges_is_not_said_twice(where: str) -> None:
    assert shown_everywhere(too_narrow())[where].count("widen it there") == 1
