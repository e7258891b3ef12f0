"""Parameters of type Boolean and Enumeration, in the words of their type."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "18-truth-values-and-enumerations"
pytestmark = needs_case(CASE)


@pytest.mark.parametrize(
    ("word", "number"), [("enable=false", "enable=0"), ("mode=Torque", "mode=5")]
)
def test_a_word_is_as_good_as_its_number(case: CaseFolder, word: str, number: str) -> None:
    for given, out in ((word, "a.csv"), (number, "b.csv"), ("inertia=0.01", "c.csv")):
        answer = case.gmfbo(f"simulate types.toml --set {given} --out {out}")
        assert answer.code == 0, answer.err
    a, b, c = (
        [line for line in (case.path / name).read_text().splitlines() if line[0] != "#"]
        for name in ("a.csv", "b.csv", "c.csv")
    )
    assert a == b
    assert a != c


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("mode=3", "expected one of Position=1, Velocity=2, Torque=5, got 3"),
        ("mode=Off", "expected one of Position=1, Velocity=2, Torque=5, got 'Off'"),
        ("enable=maybe", "expected a Boolean: true or false (1 or 0), got 'maybe'"),
    ],
)
def test_what_is_none_of_them_is_refused_with_those_that_are(
    case: CaseFolder, given: str, says: str
) -> None:
    answer = case.gmfbo(f"simulate types.toml --set {given} --out s.csv")
    assert answer.code == 2
    assert says in answer.err
