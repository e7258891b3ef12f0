"""The first law is put right once what was found beside it is known."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing

import pytest

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming import selection_round
from gmfbo.diagnosis.naming.candidate_fits import confirm, shortlist
from gmfbo.diagnosis.naming.decision import Decision, Evidence, Round
from gmfbo.diagnosis.naming.evidence_of_fit import evidence_of
from gmfbo.diagnosis.naming.forward_selection import groups_of
from gmfbo.diagnosis.naming.swapped_first import exchange_first
from gmfbo.diagnosis.screening.probes import Screened
from tests.diagnosis.short_recordings import (
    SERVO,
    decided,
    moves,
    multisine,
    open_small,
    triangle,
)

pytestmark = pytest.mark.slow

HIDDEN = {
    "stribeck_friction.level": 0.01,
    "stribeck_friction.breakaway": 0.02,
    "stribeck_friction.velocity": 0.3,
    "sensor_lag.time": 1e-3,
}
STARTS = {
    "stribeck_friction": {"level": 0.012, "breakaway": 0.018, "velocity": 0.3},
    "asymmetric_friction": {
        "level_positive": 0.015,
        "level_negative": 0.015,
        "viscous_difference": 0.0,
    },
    "sensor_lag": {"time": 8e-4},
}
THRESHOLD = 30.0


def opened(physics: dict[str, float]) -> Case:
    return open_small(SERVO.twin(), SERVO.recordings(physics, (multisine, moves, triangle)))


@pytest.fixture(scope="module")
def case() -> Iterator[Case]:
    with closing((opened_case := opened(HIDDEN)).simulations):
        yield opened_case


def fitted_beside(case: Case, model: Fitted, name: str) -> Evidence:
    start = Candidate(name, STARTS[name])
    return evidence_of(case, model, confirm(case.misfit, model, [start])[0], groups_of(case))


def begun_with(case: Case, name: str) -> Decision:
    """A search that took one friction law first, and then ended at the lag as too small."""
    names = ("stribeck_friction", "asymmetric_friction")
    laws = {n: fitted_beside(case, case.base, n) for n in names}
    first = Round(laws[name], (), tuple(laws.values()), THRESHOLD, 0.0)
    return Decision(
        rounds=[first],
        model=laws[name].fitted,
        threshold=THRESHOLD,
        groups=groups_of(case),
        refused=[fitted_beside(case, laws[name].fitted, "sensor_lag")],
    )


def test_the_right_friction_takes_the_place_of_the_first_beside_a_lag(case: Case) -> None:
    decision = begun_with(case, "asymmetric_friction")
    assert exchange_first(case, decision, 2.0 * THRESHOLD)
    (only,) = decision.rounds
    assert only.winner.name == "stribeck_friction"
    beside = decision.beside_rest
    assert beside is not None
    assert [c.effect for c in beside.without.hypothesis.effects] == ["sensor_lag"]
    assert beside.entry.winner.name == "stribeck_friction"
    assert {e.name for e in beside.entry.fitted} == {"stribeck_friction", "asymmetric_friction"}
    assert only.rivals == ()
    assert decision.model is only.winner.fitted


def test_the_right_friction_keeps_its_place(case: Case) -> None:
    """Negative control."""
    decision = begun_with(case, "stribeck_friction")
    before = list(decision.rounds)
    assert not exchange_first(case, decision, 2.0 * THRESHOLD)
    assert decision.rounds == before


def test_where_nothing_was_found_beside_it_the_first_stays(case: Case) -> None:
    decision = begun_with(case, "asymmetric_friction")
    decision.refused = []
    assert not exchange_first(case, decision, 2.0 * THRESHOLD)
    assert not exchange_first(case, Decision(model=case.base), THRESHOLD)


def coulomb_first() -> Callable[[Sequence[Screened], float], list[Candidate]]:
    """Shortlist that holds Coulomb friction alone when it is asked first."""
    asked: list[int] = []

    def short(screened: Sequence[Screened], least: float) -> list[Candidate]:
        asked.append(len(screened))
        chosen = shortlist(screened, least)
        if len(asked) > 1:
            return chosen
        return [c for c in chosen if c.effect == "coulomb_friction"]

    return short


def test_where_fits_disappoint_what_was_ranked_next_is_fitted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    physics = {"presliding_friction.level": 0.05, "presliding_friction.deflection": 0.03}
    monkeypatch.setattr(selection_round, "shortlist", coulomb_first())
    with closing((opened_case := opened(physics)).simulations):
        decision = decided(opened_case, ("coulomb_friction", "presliding_friction"))
    assert [entry.winner.name for entry in decision.rounds] == ["presliding_friction"]
