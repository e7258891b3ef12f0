"""A name that is more likely wrong than right is not given, nor what was found beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest

from gmfbo.diagnosis.case import Case
from gmfbo.diagnosis.decision import Decision
from gmfbo.diagnosis.judging import LEAST_PROBABILITY, drop_improbable
from gmfbo.diagnosis.outside import MISMATCH, unexplained
from tests.diagnosis.short_recordings import SERVO, decided, open_small

HIDDEN = {
    "coulomb_friction.level": 0.25,
    "coulomb_friction.deflection": 1e-6,
    "transport_delay.delay": 2e-3,
}
FIRST, SECOND = "coulomb_friction", "transport_delay"
LIKELY, UNLIKELY = LEAST_PROBABILITY + 1e-6, LEAST_PROBABILITY - 1e-6


@pytest.fixture(scope="module")
def found() -> Iterator[tuple[Case, Decision]]:
    """Friction, then a delay."""
    case = open_small(SERVO.twin(), SERVO.recordings(HIDDEN))
    decision = decided(case, (FIRST, SECOND))
    assert [r.winner.name for r in decision.rounds] == [FIRST, SECOND]
    yield case, decision
    case.simulations.close()


def dropped(found: tuple[Case, Decision], first: float, second: float) -> Decision:
    case, decision = found
    left = replace(decision, rounds=list(decision.rounds), refused=[])
    drop_improbable(case, left, {FIRST: first, SECOND: second})
    return left


def test_probable_names_stay(found: tuple[Case, Decision]) -> None:
    left = dropped(found, LIKELY, LIKELY)
    assert [r.winner.name for r in left.rounds] == [FIRST, SECOND]
    assert left.model is found[1].model
    assert left.refused == []


def test_an_improbable_second_name_leaves_the_model_of_the_first(
    found: tuple[Case, Decision],
) -> None:
    left = dropped(found, LIKELY, UNLIKELY)
    assert [r.winner.name for r in left.rounds] == [FIRST]
    assert left.model is left.rounds[0].winner.fitted
    assert [e.name for e in left.refused] == [SECOND]


def test_an_improbable_first_name_takes_all_others_with_it(found: tuple[Case, Decision]) -> None:
    left = dropped(found, UNLIKELY, LIKELY)
    assert left.rounds == []
    assert left.model is found[0].base
    assert [e.name for e in left.refused] == [FIRST]


def test_a_misfit_that_nothing_explains_is_far_beyond_what_a_right_twin_leaves(
    found: tuple[Case, Decision],
) -> None:
    assert unexplained(found[0], found[0].base) > MISMATCH
    right = open_small(SERVO.twin(), SERVO.recordings({}))
    try:
        assert unexplained(right, right.base) < 1.3 < MISMATCH  # as nulls leave at most
    finally:
        right.simulations.close()
