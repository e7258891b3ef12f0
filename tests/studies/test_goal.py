"""n* and regret against closed forms, and what holds for any costs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.studies.goal import Descent, Goal

COSTS = st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=20)


def test_goal_of_a_parabola_is_its_minimum_and_median() -> None:
    goal = Goal.over(np.linspace(-1.0, 1.0, 100_001) ** 2)
    assert goal.least == pytest.approx(0.0, abs=1e-9)
    # Half of [-1, 1] has x^2 below 1/4.
    assert goal.median == pytest.approx(0.25, abs=1e-4)
    assert goal.regret(goal.least) == 0.0
    assert goal.regret(goal.median) == 1.0


def test_arrival_is_the_first_real_run_within_two_percent() -> None:
    goal = Goal(least=-1.0, median=1.0)  # 2 % of the way is -0.96
    descent = Descent.of([0.5, -0.9, -0.959, -0.3, -0.961, -1.0], [goal])
    assert descent.arrival() == 5
    assert descent.arrival(4) is None
    assert descent.arrival(5) == 5
    assert descent.best == (0.5, -0.9, -0.959, -0.959, -0.961, -1.0)


def test_run_that_never_arrives_has_no_arrival() -> None:
    assert Descent.of([0.5, 0.2], [Goal(-1.0, 1.0)]).arrival() is None
    assert Descent.of([], [Goal(-1.0, 1.0)]).arrival() is None


def test_run_better_than_the_grid_has_arrived() -> None:
    descent = Descent.of([-1.1], [Goal(-1.0, 1.0)])
    assert descent.regret[0] < 0.0
    assert descent.arrival() == 1


def test_after_a_change_only_runs_of_the_changed_plant_count() -> None:
    before, after = Goal(-1.0, 1.0), Goal(0.0, 2.0)
    descent = Descent.of([-1.0, -1.0, 1.0, 0.5, 0.03], [before, after], change_after=2)
    # The optimum of the plant as it was is no arrival, and no incumbent of the plant as it is.
    assert descent.best == (-1.0, -1.0, 1.0, 0.5, 0.03)
    assert descent.regret == (0.0, 0.0, 0.5, 0.25, 0.015)
    assert descent.arrival() == 5
    assert Descent.of([-1.0, -1.0], [before, after], change_after=2).arrival() is None


def test_box_of_equally_good_gains_is_arrived_at_by_the_best_alone() -> None:
    goal = Goal(1.0, 1.0)
    assert goal.regret(1.0) == 0.0
    assert goal.regret(1.5) == 1.0


@given(costs=COSTS)
def test_best_never_rises_and_arrival_is_where_regret_says(costs: list[float]) -> None:
    descent = Descent.of(costs, [Goal(-4.0, 0.0)])
    assert np.all(np.diff(descent.best) <= 0.0)
    arrived = descent.arrival()
    early = [regret for regret in descent.regret if regret > 0.02]
    assert arrived == (len(early) + 1 if len(early) < len(costs) else None)


@given(costs=COSTS, scale=st.floats(0.1, 10.0), shift=st.floats(-3.0, 3.0))
def test_regret_does_not_depend_on_the_constants_of_the_cost(
    costs: list[float], scale: float, shift: float
) -> None:
    plain = Descent.of(costs, [Goal(-6.0, 1.0)])
    moved = Descent.of(
        [scale * cost + shift for cost in costs],
        [Goal(-6.0 * scale + shift, scale + shift)],
    )
    np.testing.assert_allclose(moved.regret, plain.regret, atol=1e-9)
