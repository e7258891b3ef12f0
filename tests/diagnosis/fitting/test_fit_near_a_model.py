"""Beside a model with effects, a fit that keeps its columns ends where one without it does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from gmfbo.diagnosis.case.case import Case, chi2_per_dof
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from tests.diagnosis.short_recordings import SERVO, moves, multisine, open_small, triangle

FRICTION = Candidate(
    "asymmetric_friction",
    {"level_positive": 0.1, "level_negative": 0.1, "viscous_difference": 0.0},
    {"deflection": 1e-5},
)
HIDDEN = {
    "coulomb_friction.level": 0.15,
    "coulomb_friction.deflection": 1e-5,
    "elastic_return.stiffness": 0.02,
}


@pytest.fixture(scope="module")
def case() -> Iterator[Case]:
    recordings = SERVO.recordings(HIDDEN, (multisine, moves, triangle), seconds=1.5)
    case = open_small(SERVO.twin(), recordings)
    with case.simulations:
        yield case


@pytest.fixture(scope="module")
def model(case: Case) -> Fitted:
    """Friction alone, which is most of what is missing."""
    hypothesis = Hypothesis(case.setting, (FRICTION,))
    found = fit(case.misfit, hypothesis, case.base.parameters)
    assert found is not None
    assert chi2_per_dof(found, case.misfit) < 2.0
    return found


def beside(model: Fitted, effect: Candidate) -> Hypothesis:
    """The model with one effect more."""
    return replace(model.hypothesis, effects=(*model.hypothesis.effects, effect))


def counted(
    case: Case,
    hypothesis: Hypothesis,
    parameters: dict[str, float],
    near: Fitted | None,
    monkeypatch: pytest.MonkeyPatch,
) -> tuple[Fitted, int]:
    """The fit, and at how many points it asked for the recordings."""
    asked = []
    run_here = case.simulations.run_here

    def noting(point: Point) -> list[Simulated]:
        asked.append(point)
        return run_here(point)

    with monkeypatch.context() as patch:
        patch.setattr(case.simulations, "run_here", noting)
        found = fit(case.misfit, hypothesis, parameters, near=near)
    assert found is not None
    return found, len(asked)


@pytest.mark.parametrize(
    "effect",
    [
        Candidate("elastic_return", {"stiffness": 0.1, "preload": 0.01}),
        Candidate("actuator_lag", {"time": 1e-3}),
    ],
    ids=lambda effect: effect.effect,
)
def test_it_ends_as_low_in_fewer_runs(
    case: Case, model: Fitted, effect: Candidate, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = case, beside(model, effect), model.parameters
    every, dear = counted(*start, None, monkeypatch)
    kept, cheap = counted(*start, model, monkeypatch)
    assert kept.chi2 < 1.001 * every.chi2
    assert cheap < dear


def test_a_model_without_effects_lends_no_columns(
    case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are few, and an effect beside none may change them all."""
    start = case, Hypothesis(case.setting, (FRICTION,)), case.base.parameters
    every, dear = counted(*start, None, monkeypatch)
    same, as_dear = counted(*start, case.base, monkeypatch)
    np.testing.assert_array_equal(same.x, every.x)
    assert as_dear == dear


def test_columns_are_those_where_the_fit_ended(
    case: Case, model: Fitted, monkeypatch: pytest.MonkeyPatch
) -> None:
    effect = Candidate("elastic_return", {"stiffness": 0.1, "preload": 0.01})
    found, _ = counted(case, beside(model, effect), model.parameters, model, monkeypatch)
    measured = case.misfit.sensitivities(
        found.hypothesis, found.x, found.simulated, range(found.x.size), parallel=False
    )
    for kept, there in zip(found.columns, measured, strict=True):
        for record, again in zip(kept, there, strict=True):
            np.testing.assert_array_equal(np.array(record), np.array(again))
