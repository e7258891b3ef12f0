"""A search for best values goes as far as it can matter."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.modes.posterior_mode import ModeSearch
from gmfbo.diagnosis.comparison.modes.trial_points import TrialPoints
from gmfbo.diagnosis.comparison.numbers import AT_THE_END, SETTLED
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.priors import Prior
from gmfbo.diagnosis.comparison.row_fits import cost
from tests.diagnosis.noise.planted_noise import opened, planted

SIGMA = 3e-4  # [rad]


def test_what_stays_far_behind_the_best_fit_is_not_searched_on() -> None:
    with opened(planted(SIGMA)) as case:
        search = (stated := comparison_of(case, [])).search
        ledger = search.opened(stated.first)
        base = ledger.rows[frozenset()]
        wrong = {name: 1.5 * value for name, value in base.parameters.items()}
        fit = ModeSearch(search.problem, ledger.whitening, base.hypothesis)
        best = cost(base, ledger.whitening)
        behind = fit.fitted(wrong, rival=best - 1e9)
        level = fit.fitted(wrong, rival=best)
        runs = search.problem.simulations.runs
        again = fit.again(cast(Any, level))
        assert again is level
        assert search.problem.simulations.runs == runs
        more = fit.again(cast(Any, level), iterations=1, settled=0.0)
    assert behind is not None
    assert level is not None
    np.testing.assert_allclose(behind.x, list(wrong.values()), rtol=1e-4)
    assert not behind.converged
    assert level.converged
    assert level.x == pytest.approx(base.x, rel=1e-3)
    gained = cost(level, ledger.whitening) - cost(more, ledger.whitening)
    assert 0.0 <= gained < SETTLED  # as promised


def test_a_rival_keeps_its_columns_while_predictions_stay_and_what_is_told_has_exact_ones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    measured: list[list[NDArray[np.float64]]] = []
    usual = TrialPoints.columns

    def seen(self: TrialPoints, at: Any) -> list[NDArray[np.float64]]:
        measured.append(at.residual)
        return usual(self, at)

    monkeypatch.setattr(TrialPoints, "columns", seen)
    with opened(planted(SIGMA)) as case:
        search = (stated := comparison_of(case, [])).search
        ledger = search.opened(stated.first)
        base = ledger.rows[frozenset()]
        wrong = {name: 1.0001 * value for name, value in base.parameters.items()}

        def fitted(settled: float, rival: float) -> tuple[Any, int]:
            measured.clear()
            fit = ModeSearch(search.problem, ledger.whitening, base.hypothesis)
            return fit.fitted(wrong, settled=settled, rival=rival), len(measured)

        behind, few = fitted(SETTLED, 1e12)
        told, more = fitted(AT_THE_END, np.inf)
        assert few < more
        np.testing.assert_allclose(behind.x, told.x, rtol=1e-3)
        assert cost(behind, ledger.whitening) - cost(told, ledger.whitening) < SETTLED
        # A rival that leads from now on is measured where it stands.
        measured.clear()
        other = replace(ledger.whitening)
        led = ModeSearch(search.problem, other, base.hypothesis).again(behind)
    assert behind.columns_at
    moved = [a - b for a, b in zip(led.columns_at or led.residual, led.residual, strict=True)]
    assert ledger.whitening.square(moved) <= SETTLED


def test_columns_are_of_what_the_logger_stores() -> None:
    """Of a column that is two rows late, so is what a parameter changes in it."""
    with opened(planted(SIGMA)) as case:
        search = (stated := comparison_of(case, [])).search
        base, problem = search.opened(stated.first).rows[frozenset()], search.problem
        late = np.array([20.0 if n[0] == "shift" else 0.0 for n in problem.nuisances])
        points = TrialPoints(problem, base.hypothesis)
        at = points.at(base.u, late, base.own)
        assert at is not None
        columns = points.columns(at)
        for i in range(base.u.size):
            step = 1e-3 * (np.arange(base.u.size) == i)
            beyond, short = (points.at(base.u + s * step, late, base.own) for s in (1.0, -1.0))
            assert beyond is not None
            assert short is not None
            for after, before, made in zip(beyond.residual, short.residual, columns, strict=True):
                slope = (before - after) / 2e-3
                left = np.linalg.norm(slope - made[i], axis=-1)
                assert np.all(left <= 0.02 * np.linalg.norm(slope, axis=-1))


class Parabola(ModeSearch):
    """A search whose cost is a parabola of two logarithms, from its middle."""

    def __init__(self, curvature: NDArray[np.float64], slope: NDArray[np.float64]) -> None:
        priors = (Prior(1e-9, 1e9, True, "uniform", 0.0, 0.0),) * 2
        self._points = cast(
            Any, SimpleNamespace(priors=priors, columns=lambda at: [], renewed=lambda at, own: own)
        )
        self._parts, self._made = None, (curvature, slope)

    def _normal(self, at: Any, columns: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return self._made

    def step(self, damping: float = 0.0) -> tuple[NDArray[np.float64], float]:
        none = np.zeros(0)
        at = SimpleNamespace(
            u=np.zeros(2), nuisances=none, at_zero=none > 0.0, one_sided=none > 0.0
        )
        return self._step(cast(Any, at), [], damping)

    def _squared_change(self, at: Any, before: Any) -> float:
        return 0.0

    def _measured_at(self, at: Any) -> Any:
        return at

    def _with_finer_steps(self, at: Any, columns: Any) -> tuple[Any, Any]:
        return at, columns


def test_a_step_of_what_bends_stays_in_a_narrow_valley() -> None:
    stiff, soft = np.array([3.0, 1.0]) / np.sqrt(10.0), np.array([1.0, -3.0]) / np.sqrt(10.0)
    curvature = 100.0 * np.outer(stiff, stiff) + np.outer(soft, soft)
    wanted = np.array([2.0, -6.0])
    step, gain = Parabola(curvature, curvature @ wanted).step()
    np.testing.assert_allclose(step, [1.0 / 3.0, -1.0], atol=0.02)
    assert gain > 0.0


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4),
    st.lists(st.floats(-10.0, 10.0), min_size=2, max_size=2),
    st.sampled_from([0.0, 1e-3, 1.0]),
)
def test_a_step_within_bounds_never_promises_a_loss(
    root: list[float], wanted: list[float], damping: float
) -> None:
    factor = np.reshape(root, (2, 2))
    curvature = factor @ factor.T + 0.1 * np.eye(2)
    step, gain = Parabola(curvature, curvature @ np.array(wanted)).step(damping)
    assert np.abs(step).max() <= 1.0 + 1e-12
    assert gain >= -1e-9


def test_a_step_like_one_that_failed_is_not_tried() -> None:
    """Where friction makes a cost rough, a step nine tenths as long fails as the whole one did."""
    promised = []

    class Rough(Parabola):
        def cost(self, at: Any) -> float:
            return 100.0

        def _step(self, at: Any, columns: Any, damping: float) -> tuple[NDArray[np.float64], float]:
            return np.zeros(2), 8.0 / (1.0 + damping)

        def _moved(self, at: Any, step: Any, damping: float) -> None:
            promised.append(8.0 / (1.0 + damping))

        def _ended(self, at: Any, columns: Any, converged: bool, measured: Any = None) -> Any:
            return SimpleNamespace(converged=converged)

    rough = Rough(np.eye(2), np.zeros(2))
    ended = rough._searched(cast(Any, None), [], 10, 0.1, np.inf)
    assert ended.converged
    assert 4 <= len(promised) <= 8
    assert all(after <= 0.5 * before for before, after in pairwise(promised))


class Tried(Parabola):
    """A search that promises half as much at each shorter step, and loses as is given."""

    def __init__(self, lost: list[float]) -> None:
        super().__init__(np.eye(2), np.zeros(2))
        self.lost, self.tried = lost, 0

    def cost(self, at: Any) -> float:
        return 100.0 if at is None else float(at)

    def _step(self, at: Any, columns: Any, damping: float) -> tuple[NDArray[np.float64], float]:
        return np.zeros(2), 8.0 / (1.0 + damping)

    def _moved(self, at: Any, step: Any, damping: float) -> Any:
        self.tried += 1
        return 100.0 + self.lost[self.tried - 1]

    def _ended(self, at: Any, columns: Any, converged: bool, measured: Any = None) -> Any:
        return SimpleNamespace(cost=self.cost(at), converged=converged)


def test_where_shorter_steps_lose_as_much_the_cost_is_rough_and_the_search_ends() -> None:
    search = Tried([500.0, 400.0, 300.0, -50.0])
    ended: Any = search._searched(cast(Any, None), [], 10, 0.1, np.inf)
    assert (search.tried, ended.cost, ended.converged) == (3, 100.0, True)


def test_where_shorter_steps_lose_less_the_search_goes_on() -> None:
    search = Tried([500.0, 400.0, 20.0, -1.0, 200.0, 150.0, 140.0])
    ended: Any = search._searched(cast(Any, None), [], 10, 0.1, np.inf)
    assert (search.tried, ended.cost) == (7, 99.0)
