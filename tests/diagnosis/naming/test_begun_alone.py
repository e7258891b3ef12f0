"""What was found alone under other parameters is fitted beside a name from there."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import pytest

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.naming.candidate_fits import confirm
from gmfbo.diagnosis.naming.decision import Decision, Round
from gmfbo.diagnosis.naming.evidence_of_fit import evidence_of
from gmfbo.diagnosis.naming.forward_selection import groups_of
from gmfbo.diagnosis.naming.selection_round import _begun_alone
from gmfbo.diagnosis.screening.testable_effects import candidates
from tests.diagnosis.servo_recordings import HIDDEN, opened

pytestmark = pytest.mark.slow

DELAY, PUSH = 2e-3, 0.05
PHYSICS = {"transport_delay.delay": DELAY, "constant_torque_offset.level": PUSH}
THRESHOLD = 30.0


@pytest.fixture(scope="module")
def case() -> Iterator[Case]:
    with closing((opened_case := opened(PHYSICS)).simulations):
        yield opened_case


@pytest.fixture(scope="module")
def push(case: Case) -> Fitted:
    """The push alone, with an inertia that makes up for the delay."""
    starts = candidates(["constant_torque_offset"], case.setting.excitation)
    (found,) = confirm(case.misfit, case.base, starts[:1])
    return found


def delay_alone(case: Case) -> Fitted:
    start = Hypothesis(case.setting, (Candidate("transport_delay", {"delay": DELAY}),))
    found = fit(case.misfit, start, HIDDEN)
    assert found is not None
    return found


def decided(case: Case, push: Fitted, alone: Fitted) -> Decision:
    groups = groups_of(case)
    winner, other = (evidence_of(case, case.base, f, groups) for f in (push, alone))
    entry = Round(winner, (), (winner, other), THRESHOLD, THRESHOLD)
    return Decision([entry], push, threshold=THRESHOLD, groups=groups)


def test_a_delay_that_an_inertia_made_up_for_is_found_beside_a_push(
    case: Case, push: Fitted
) -> None:
    assert push.parameters["inertia"] > 1.1 * HIDDEN["inertia"]
    (found,) = _begun_alone(case, decided(case, push, delay_alone(case)), [])
    assert [c.effect for c in found.hypothesis.effects] == [
        "constant_torque_offset",
        "transport_delay",
    ]
    assert found.hypothesis.effects[-1].values["delay"] == pytest.approx(DELAY, rel=0.02)
    assert found.parameters["inertia"] == pytest.approx(HIDDEN["inertia"], rel=0.01)
    assert push.chi2 - found.chi2 > 10.0 * THRESHOLD


def test_the_better_of_two_fits_of_one_effect_is_kept(case: Case, push: Fitted) -> None:
    decision = decided(case, push, delay_alone(case))
    (better,) = _begun_alone(case, decision, [])
    assert _begun_alone(case, decision, [better])[0].chi2 == better.chi2


def test_under_the_same_parameters_and_before_any_name_nothing_is_tried(
    case: Case, push: Fitted
) -> None:
    runs = case.simulations.runs
    assert _begun_alone(case, decided(case, push, push), [push]) == [push]
    assert _begun_alone(case, Decision(model=case.base), [push]) == [push]
    assert case.simulations.runs == runs
