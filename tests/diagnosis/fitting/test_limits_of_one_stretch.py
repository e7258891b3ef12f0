"""A limit that one stretch alone shows keeps its size while that stretch is left out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.held_out_split import split_of
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.fitting.simulated_left_out import simulated_left_out, squares
from gmfbo.diagnosis.naming import evidence_of_fit
from gmfbo.diagnosis.naming.evidence_of_fit import evidence_of
from gmfbo.diagnosis.naming.forward_selection import groups_of
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.validating.validation import validate
from tests.diagnosis.short_recordings import SERVO, moves, multisine, open_small, triangle

LIMIT = 1.25  # [N m] of 1.4 that the moves ask for; nothing else asks for more than 1.1


@pytest.fixture(scope="module")
def limited() -> Iterator[tuple[Case, Fitted]]:
    physics = {"actuator_saturation.limit": LIMIT}
    recordings = SERVO.recordings(physics, (multisine, moves, triangle), seconds=2.0)
    case = open_small(SERVO.twin(), recordings)
    with case.simulations:
        start = Candidate("actuator_saturation", {"limit": LIMIT})
        hypothesis = Hypothesis(case.setting, (start,))
        fitted = fit(case.misfit, hypothesis, case.base.parameters, iterations=10)
        assert fitted is not None
        yield case, fitted


def limits_simulated(
    case: Case, fitted: Fitted, held: int, monkeypatch: pytest.MonkeyPatch
) -> set[float]:
    """Limits at which a fit without each stretch was simulated."""
    seen: list[Point] = []
    run = case.simulations.run

    def noting(points: Sequence[Point]) -> list[list[Simulated]]:
        seen.extend(points)
        return run(points)

    monkeypatch.setattr(case.simulations, "run", noting)
    left = simulated_left_out(case.misfit, fitted, groups_of(case), held)
    assert left.sum() >= squares(fitted.residual, groups_of(case)).sum() - 1.0
    return {point.physics["actuator_saturation.limit"] for point in seen}


def test_what_is_held_stays_and_the_rest_is_fitted_without_each_stretch(
    limited: tuple[Case, Fitted], monkeypatch: pytest.MonkeyPatch
) -> None:
    case, fitted = limited
    (effect,) = fitted.hypothesis.effects
    assert limits_simulated(case, fitted, 1, monkeypatch) == {effect.values["limit"]}


def test_without_holding_it_the_limit_moves(
    limited: tuple[Case, Fitted], monkeypatch: pytest.MonkeyPatch
) -> None:
    case, fitted = limited
    assert len(limits_simulated(case, fitted, 0, monkeypatch)) > 1


def test_a_limit_that_one_recording_shows_keeps_nearly_all_of_its_gain(
    limited: tuple[Case, Fitted],
) -> None:
    case, fitted = limited
    groups = groups_of(case)
    inside = squares(case.base.residual, groups) - squares(fitted.residual, groups)
    assert inside.sum() > 1e4
    assert evidence_of(case, case.base, fitted, groups).gain > 0.95 * inside.sum()


@pytest.mark.parametrize(("limit", "keeps"), [(LIMIT, True), (1.03 * LIMIT, False)])
def test_a_limit_that_no_other_stretch_foretells_keeps_its_gain_where_it_explains_all(
    limited: tuple[Case, Fitted], limit: float, keeps: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By parameters of the other stretches, an axis may never come to the limit.

    3 % beside its size, the limit explains part of what is there: the negative control.
    """
    case, fitted = limited
    groups = groups_of(case)
    without = squares(case.base.residual, groups)
    monkeypatch.setattr(evidence_of_fit, "simulated_left_out", lambda *args: without)
    x = fitted.x * np.append(np.ones(fitted.x.size - 1), limit / LIMIT)
    (simulated,) = case.simulations.run([fitted.hypothesis.point(x)])
    there = replace(fitted, x=x, residual=case.misfit.residual(simulated))
    after = squares(there.residual, groups)
    gain = evidence_of(case, case.base, there, groups).gain
    assert (gain > 0.99 * float(without.sum() - after.sum())) is keeps


def test_recordings_that_never_reach_a_limit_say_nothing_of_it(
    limited: tuple[Case, Fitted],
) -> None:
    """Neither that it removes nothing of their error, nor that their drift contradicts it.

    What differs there is the inertia that had made up for the limit.
    """
    case, fitted = limited
    change = tuple(a - b for a, b in zip(fitted.residual, case.base.residual, strict=True))
    split = split_of(case, [change], fitted)
    assert "rec1.csv" in split.names_fitted  # the moves
    result = validate(case, fitted, split, None)
    assert not result.fit.removes_nothing
    assert not result.contradicts_names
