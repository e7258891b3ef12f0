"""What the best gains alone do not tell is said in a line at the end."""

from __future__ import annotations

import re

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "25-terminal-says-nothing"
pytestmark = [needs_case(CASE), pytest.mark.slow]


@pytest.mark.parametrize(
    ("study", "said"),
    [
        ("c", "no run meets the limit rise time <= 0.0001; the nearest has 0.0"),
        ("const", "all 6 runs score the same"),
        ("h1", "all 4 runs score the same"),
    ],
)
def test_a_line_says_what_is_wrong(case: CaseFolder, study: str, said: str) -> None:
    answer = case.gmfbo(f"tune {study}.toml")
    assert answer.code == 0, answer.err
    assert said in answer.out


def test_gains_at_both_ends_of_the_box_are_told(case: CaseFolder) -> None:
    answer = case.gmfbo("tune edge.toml")
    assert answer.code == 0, answer.err
    assert re.search(r"best ctl\.K[pd] = \S+ lies at the (upper|lower) end", answer.out)


def test_own_metrics_are_not_told_in_seconds(case: CaseFolder) -> None:
    answer = case.gmfbo("tune e.toml")
    assert answer.code == 0, answer.err
    assert re.search(r"peak torque +[\d.]+ (?!s\b)", answer.out)
    assert not re.search(r"(energy|peak torque|iae) +[\d.]+ s", answer.out)


def test_a_response_whose_noise_leaves_the_band_is_told(case: CaseFolder) -> None:
    answer = case.gmfbo("tune v0.6.toml")
    assert answer.code == 0, answer.err
    assert "Warning" not in answer.err
    assert "the noise of speed leaves the band of 2 % until the end" in answer.out
    assert "widen [objective] band or set its filter" in answer.out


def test_gains_at_the_end_of_a_logarithmic_box_are_told(case: CaseFolder) -> None:
    answer = case.gmfbo("tune log12.toml")
    assert answer.code == 0, answer.err
    assert re.search(r"best \S+ = \S+ lies at the (upper|lower) end", answer.out)
