"""A fit that stopped early goes on beside any further effect, which deserves no credit for it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.candidate_fits import confirm
from gmfbo.diagnosis.naming.decision import Decision, Round
from gmfbo.diagnosis.naming.evidence_of_fit import evidence_of
from gmfbo.diagnosis.naming.forward_selection import groups_of
from gmfbo.diagnosis.naming.selection_round import go_where_led
from gmfbo.diagnosis.screening.testable_effects import candidates
from tests.diagnosis.port_cases import open_servo

pytestmark = pytest.mark.slow

FRICTION = {"coulomb_friction.level": 0.05}
GRAVITY = {"gravity_torque.sine": 0.1}
LAG = {"actuator_lag.time": 0.003}
THRESHOLD = 20.0


@pytest.fixture(scope="module")
def case() -> Iterator[Case]:
    found = open_servo(FRICTION)
    yield found
    found.simulations.close()


@pytest.fixture(scope="module")
def late() -> Iterator[Case]:
    found = open_servo(LAG)
    yield found
    found.simulations.close()


@pytest.fixture(scope="module")
def loaded() -> Iterator[Case]:
    found = open_servo(FRICTION | GRAVITY)
    yield found
    found.simulations.close()


def fitted(case: Case, model: Fitted, name: str) -> Fitted:
    return confirm(case.misfit, model, candidates([name], case.setting.excitation)[:1])[0]


def decided(case: Case, model: Fitted, rival: Fitted) -> Decision:
    """One effect accepted, with a rival."""
    groups = groups_of(case)
    winner, other = (evidence_of(case, case.base, f, groups) for f in (model, rival))
    entry = Round(winner, (other,), (winner, other), THRESHOLD, THRESHOLD)
    return Decision([entry], model, threshold=THRESHOLD, groups=groups)


def stopped_early(case: Case, found: Fitted) -> Fitted:
    """The same law far from where its fit ends."""
    (law,) = found.hypothesis.effects
    off = law.with_values({name: 1.5 * value for name, value in law.values.items()})
    there = replace(found.hypothesis, effects=(off,))
    start = {name: 1.2 * value for name, value in found.parameters.items()}
    stopped = fit(case.misfit, there, start, iterations=1)
    assert stopped is not None
    return stopped


def with_nothing_more(case: Case, found: Fitted) -> Fitted:
    """The fit that goes on, beside a dead zone that does nothing."""
    nothing = Candidate("actuator_dead_zone", {"width": 1e-9})
    joined = replace(found.hypothesis, effects=(*found.hypothesis.effects, nothing))
    there = fit(case.misfit, joined, found.parameters)
    assert there is not None
    return there


def test_what_goes_on_without_the_effect_goes_on_and_its_rivals_with_it(late: Case) -> None:
    lag, rival = (fitted(late, late.base, name) for name in ("actuator_lag", "sensor_lag"))
    decision = decided(late, stopped_early(late, lag), stopped_early(late, rival))
    assert decision.model is not None
    assert decision.model.chi2 > lag.chi2 + 2.0 * THRESHOLD
    assert go_where_led(late, decision, [with_nothing_more(late, lag)])
    (entry,) = decision.rounds
    assert decision.model is entry.winner.fitted
    assert decision.model.chi2 == pytest.approx(lag.chi2, abs=THRESHOLD)
    assert entry.winner.gain > 0.5 * (late.base.chi2 - lag.chi2)
    (kept,) = entry.rivals
    assert kept.chi2 == pytest.approx(rival.chi2, abs=THRESHOLD)


def test_what_a_second_effect_explains_by_itself_is_left_to_it(loaded: Case) -> None:
    friction = fitted(loaded, loaded.base, "coulomb_friction")
    decision = decided(loaded, friction, friction)
    both = fitted(loaded, friction, "gravity_torque")
    assert friction.chi2 - both.chi2 > 10.0 * THRESHOLD
    assert not go_where_led(loaded, decision, [both])
    assert decision.model is friction


def test_before_anything_is_named_nothing_is_tried(case: Case) -> None:
    friction = fitted(case, case.base, "coulomb_friction")
    runs = case.simulations.runs
    assert not go_where_led(case, Decision(model=case.base, threshold=THRESHOLD), [friction])
    assert case.simulations.runs == runs
