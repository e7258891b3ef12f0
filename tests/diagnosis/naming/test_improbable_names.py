"""A name that is more likely wrong than right is not given, nor what was found beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.naming.withdrawn_names import (
    LEAST_PROBABILITY,
    drop_improbable,
    give_way_to_limit,
)
from gmfbo.diagnosis.outside.beyond_library import MISMATCH, unexplained
from tests.diagnosis.short_recordings import SERVO, decided, open_small

pytestmark = pytest.mark.slow

HIDDEN = {
    "coulomb_friction.level": 0.25,
    "coulomb_friction.deflection": 1e-6,
    "transport_delay.delay": 2e-3,
}
FIRST, SECOND = "coulomb_friction", "transport_delay"
LARGER = "stribeck_friction"
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


@pytest.fixture(scope="module")
def laws() -> Iterator[tuple[Case, Decision]]:
    """Coulomb friction, and Stribeck friction as if that had been named in its place."""
    friction = {name: value for name, value in HIDDEN.items() if name.startswith(FIRST)}
    case = open_small(SERVO.twin(), SERVO.recordings(friction))
    decision = decided(case, (FIRST, LARGER))
    (entry,) = decision.rounds
    larger = next(e for e in entry.fitted if e.name == LARGER)
    yield case, replace(decision, rounds=[replace(entry, winner=larger)], model=larger.fitted)
    case.simulations.close()


@pytest.mark.parametrize(
    ("larger", "limit", "named"),
    [(UNLIKELY, LIKELY, FIRST), (UNLIKELY, UNLIKELY, LARGER), (LIKELY, LIKELY, LARGER)],
)
def test_an_improbable_law_gives_way_to_its_probable_limit(
    laws: tuple[Case, Decision], larger: float, limit: float, named: str
) -> None:
    case, decision = laws
    left = replace(decision, rounds=list(decision.rounds))
    probabilities = {LARGER: larger}
    give_way_to_limit(case, left, probabilities, lambda base, entry: limit)
    (entry,) = left.rounds
    assert entry.winner.name == named
    assert left.model is entry.winner.fitted
    assert probabilities[named] == (limit if named == FIRST else larger)


def test_a_law_without_limits_gives_way_to_nothing(found: tuple[Case, Decision]) -> None:
    case, decision = found
    left = replace(decision, rounds=list(decision.rounds))
    give_way_to_limit(case, left, {FIRST: LIKELY, SECOND: UNLIKELY}, lambda base, entry: 1.0)
    assert left.rounds == decision.rounds


def test_a_misfit_that_nothing_explains_is_far_beyond_what_a_right_twin_leaves(
    found: tuple[Case, Decision],
) -> None:
    assert unexplained(found[0], found[0].base) > MISMATCH
    right = open_small(SERVO.twin(), SERVO.recordings({}))
    try:
        assert unexplained(right, right.base) < 1.3 < MISMATCH  # as nulls leave at most
    finally:
        right.simulations.close()
