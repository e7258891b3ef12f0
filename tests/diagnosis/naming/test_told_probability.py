"""A probability grows with belief and evidence, and is worth what the draw says."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.comparison.numbers import DOUBTED
from gmfbo.diagnosis.naming.decision import Round
from gmfbo.diagnosis.naming.worth import worth
from gmfbo.diagnosis.result.named_effect import RivalShare

BELIEFS, GAINS = st.floats(0.0, 1.0), st.floats(-10.0, 1e7)


@given(BELIEFS, BELIEFS, GAINS, GAINS)
def test_who_believes_more_on_more_evidence_is_never_less_sure(
    one: float, other: float, gain: float, more: float
) -> None:
    (low, high), (little, much) = sorted((one, other)), sorted((gain, more))
    assert 0.0 < worth(low, little) <= worth(high, much) < 1.0


def test_weak_evidence_is_no_fact_however_sure_the_comparison_is() -> None:
    assert worth(1.0, 1.0) < 0.8 < worth(1.0, 100.0)


def test_what_is_told_of_a_set_falls_with_its_members() -> None:
    shares = (RivalShare("a", 0.6), RivalShare("b", 0.3))
    sure = Round(None, (), 1.0, 0.9, shares, 1e3, {}, most=0.8)  # type: ignore[arg-type]
    weaker = sure.held_against(left=0.6)
    same = sure.held_against(left=0.5)
    assert weaker.probability == DOUBTED
    assert sum(one.probability for one in weaker.shares) == pytest.approx(weaker.probability)
    assert same.probability == 0.8


def test_names_that_leave_most_of_the_error_are_no_facts() -> None:
    sure = Round(None, (), 1.0, 0.9, (), 1e7, {})  # type: ignore[arg-type]
    assert sure.held_against(left=0.4).probability > 0.8
    assert sure.held_against(left=0.6).probability < 0.8
