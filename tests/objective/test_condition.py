"""Conditions of the safety envelope: formulas of signals, and nothing that could run."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.errors import InputError
from gmfbo.objective.condition import Condition

TIME = np.linspace(0.0, 1.0, 5)
SIGNALS = {
    "position": np.array([0.0, 0.4, 1.2, np.nan, 1.0]),
    "reference": np.ones(5),
}


def test_a_condition_holds_row_by_row_and_passes_blank_cells() -> None:
    condition = Condition.parse("abs(position - reference) < 0.5")
    assert condition.names == {"position", "reference"}
    np.testing.assert_array_equal(condition.holds(TIME, SIGNALS), [False, False, True, True, True])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("time < 0.6", [True, True, True, False, False]),
        ("time < 0.3 or position > 0.9", [True, True, True, True, True]),
        ("not time < 0.6 and reference == reference", None),
        ("0 <= position <= 1", [True, True, False, True, True]),
        ("max(position, 0.5) < 1.1 and -position ** 2 > -2", [True, True, False, True, True]),
        ("1 / time > 3", [True, True, False, False, False]),
        ("1 < 2", [True] * 5),
    ],
)
def test_formulas_mean_what_they_mean_in_mathematics(
    text: str, expected: list[bool] | None
) -> None:
    if expected is None:
        with pytest.raises(InputError, match="is not understood"):
            Condition.parse(text)
        return
    np.testing.assert_array_equal(Condition.parse(text).holds(TIME, SIGNALS), expected)


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-5, 5))
def test_arithmetic_is_pythons(a: float, b: float, c: float) -> None:
    signals = {name: np.array([value]) for name, value in zip("abc", (a, b, c), strict=True)}
    held = Condition.parse("a * b - c < abs(a) + c / 3").holds(np.zeros(1), signals)
    assert held[0] == (a * b - c < abs(a) + c / 3)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true') == 0",
        "position.__class__ == 1",
        "(lambda: 1)() < 2",
        "[x for x in position] < 1",
        "position[0] < 1",
        "'a' < 'b'",
        "True < 2",
        "(p := 3) < 4",
        "position < 1 if time > 0 else position > 1",
        "abs(position, key=1) < 1",
    ],
)
def test_whatever_is_no_formula_is_refused_before_anything_runs(text: str) -> None:
    with pytest.raises(InputError, match=r"expression"):
        Condition.parse(text)


def test_refusals_say_what_to_write() -> None:
    with pytest.raises(InputError, match=r"no function 'abbs'; did you mean 'abs'\?"):
        Condition.parse("abbs(position) < 1")
    with pytest.raises(InputError, match="expected a comparison"):
        Condition.parse("position - reference")
    with pytest.raises(InputError, match="expected a formula such as"):
        Condition.parse("position <")
    with pytest.raises(InputError, match="max takes at least two values"):
        Condition.parse("max(position) < 1")
