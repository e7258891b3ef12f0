"""A probability grows with belief and evidence, and is worth what the draw says."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.naming.decision import Round
from gmfbo.diagnosis.naming.worth import has_fallen, worth
from gmfbo.diagnosis.result.named_effect import RivalShare

BELIEFS, GAINS = st.floats(0.0, 1.0), st.floats(-10.0, 1e7)


@given(BELIEFS, BELIEFS, GAINS, GAINS, st.booleans(), st.booleans())
def test_who_believes_more_on_more_evidence_is_never_less_sure(
    one: float, other: float, gain: float, more: float, before: bool, after: bool
) -> None:
    (low, high), (little, much) = sorted((one, other)), sorted((gain, more))
    weak = worth(low, little, fell=before and after)
    assert 0.0 < weak <= worth(high, much, fell=before or after) < 1.0


def test_weak_evidence_is_no_fact_however_sure_the_comparison_is() -> None:
    assert worth(1.0, 5.0, fell=True) < 0.8 < worth(1.0, 100.0, fell=True)


def test_what_helps_no_recording_that_was_not_fitted_is_no_fact() -> None:
    assert worth(1.0, 1e7, fell=False) < 0.8


@pytest.mark.parametrize(
    ("errors", "fell"),
    [
        ([(0.02, 0.01), (0.1, 0.3)], True),
        ([(0.02, 0.0199)], False),
        ([(0.02, math.nan), (None, 0.01), (0.01, None)], False),
        ([], False),
    ],
)
def test_an_error_falls_where_a_signal_is_met_better_by_more_than_the_last_digit(
    errors: list[tuple[float | None, float | None]], fell: bool
) -> None:
    assert has_fallen(errors) is fell


def test_what_is_told_of_a_set_falls_with_its_members() -> None:
    shares = (RivalShare("a", 0.6), RivalShare("b", 0.3))
    sure = Round(None, (), 1.0, 0.9, shares, 1e3, {}, most=0.8)  # type: ignore[arg-type]
    weaker = sure.held_against(fell=False, left=0.0)
    same = sure.held_against(fell=True, left=0.5)
    assert weaker.probability == worth(1.0, 1e3, fell=False)
    assert sum(one.probability for one in weaker.shares) == pytest.approx(weaker.probability)
    assert same.probability == 0.8


def test_names_that_leave_most_of_the_error_are_no_facts() -> None:
    sure = Round(None, (), 1.0, 0.9, (), 1e7, {})  # type: ignore[arg-type]
    assert sure.held_against(fell=True, left=0.4).probability > 0.8
    assert sure.held_against(fell=True, left=0.6).probability < 0.8
