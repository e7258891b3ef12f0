"""A fit that keeps columns ends where one does that measures all of them at each step."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import least_squares

from gmfbo.diagnosis.case import Case
from gmfbo.diagnosis.fitting import Fitted, fit, stacked
from gmfbo.diagnosis.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.simulated import Point, Simulated
from tests.diagnosis.short_recordings import SERVO, moves, multisine, open_small, triangle

HIDDEN = {"coulomb_friction.level": 0.15, "coulomb_friction.deflection": 1e-5}


@pytest.fixture(scope="module")
def case() -> Iterator[Case]:
    recordings = SERVO.recordings(HIDDEN, (multisine, moves, triangle), seconds=1.5)
    case = open_small(SERVO.twin(), recordings)
    with case.simulations:
        yield case


def counted(
    case: Case, effect: Candidate, near: Fitted | None, monkeypatch: pytest.MonkeyPatch
) -> tuple[Fitted, int]:
    """The fit, and at how many points it asked for the recordings."""
    asked = []
    run_here = case.simulations.run_here

    def noting(point: Point) -> list[Simulated]:
        asked.append(point)
        return run_here(point)

    with monkeypatch.context() as patch:
        patch.setattr(case.simulations, "run_here", noting)
        hypothesis = Hypothesis(case.setting, (effect,))
        found = fit(case.misfit, hypothesis, case.base.parameters, near=near)
    assert found is not None
    return found, len(asked)


def with_every_column(case: Case, effect: Candidate) -> tuple[float, int]:
    """chi2 by SciPy alone, all columns measured at each step, and at how many points it asked."""
    hypothesis, asked = Hypothesis(case.setting, (effect,)), 0

    def residual(x: NDArray[np.float64]) -> NDArray[np.float64]:
        nonlocal asked
        asked += 1
        runs = case.simulations.run_here(hypothesis.point(x))
        return np.concatenate(case.misfit.residual(runs))

    def slopes(x: NDArray[np.float64]) -> NDArray[np.float64]:
        nonlocal asked
        asked += x.size
        runs = case.simulations.run_here(hypothesis.point(x))
        every = range(x.size)
        columns = case.misfit.sensitivities(hypothesis, x, runs, every, parallel=False)
        return -np.concatenate(stacked(case.misfit, columns), axis=1).T

    found = least_squares(
        residual,
        hypothesis.start(case.base.parameters),
        jac=slopes,
        bounds=hypothesis.bounds,
        x_scale=hypothesis.scales,
        ftol=3e-4,
        xtol=1e-4,
    )
    return 2.0 * found.cost, asked


@pytest.mark.parametrize(
    "effect",
    [
        Candidate("coulomb_friction", {"level": 0.05}, {"deflection": 1e-5}),
        Candidate("elastic_return", {"stiffness": 0.1, "preload": 0.01}),
        Candidate("actuator_lag", {"time": 1e-3}),
    ],
    ids=lambda effect: effect.effect,
)
def test_it_ends_as_low_in_fewer_runs(
    case: Case, effect: Candidate, monkeypatch: pytest.MonkeyPatch
) -> None:
    least, dear = with_every_column(case, effect)
    found, cheap = counted(case, effect, case.base, monkeypatch)
    assert found.chi2 < 1.002 * least
    assert cheap < dear


def test_a_fit_near_itself_costs_less_still(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    effect = Candidate("coulomb_friction", {"level": 0.05}, {"deflection": 1e-5})
    found, first = counted(case, effect, case.base, monkeypatch)
    again, asked = counted(case, found.hypothesis.effects[0], found, monkeypatch)
    assert again.chi2 == pytest.approx(found.chi2, rel=1e-3)
    assert asked < first


def test_columns_are_those_where_the_fit_ended(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    effect = Candidate("coulomb_friction", {"level": 0.05}, {"deflection": 1e-5})
    found, _ = counted(case, effect, case.base, monkeypatch)
    measured = case.misfit.sensitivities(
        found.hypothesis, found.x, found.simulated, range(found.x.size), parallel=False
    )
    for kept, there in zip(found.columns, measured, strict=True):
        for record, again in zip(kept, there, strict=True):
            np.testing.assert_array_equal(np.array(record), np.array(again))
