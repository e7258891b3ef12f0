"""Difference steps that are so long that a law bends within them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.difference_steps import Judge, bent_shares, with_finer_steps
from gmfbo.diagnosis.fitting.hypothesis import DIFFERENCE_STEP, Candidate, Hypothesis, Setting
from tests.physics.excitations import TYPICAL

Array = NDArray[np.float64]

LIMIT = "supply_voltage_limit.limit"
HYPOTHESIS = Hypothesis(
    Setting((), TYPICAL), (Candidate("supply_voltage_limit", {"limit": 8.0, "slope": 0.5}),)
)
X = np.array([8.0, 0.5])
SHOWN = np.array([200.0, 1.0])  # the finer step is a tenth of the usual one


def judged_by(response: Callable[[float], Array]) -> Judge:
    """Judge of a limit's response to its move, as a share of the limit."""

    def judged(moves: Array) -> list[float | None]:
        seen = [[response(float(move[0]) / X[0])] for move in moves]
        return bent_shares(seen, lambda own: float(np.sum(own[0] ** 2)))

    return judged


def cut(move: float) -> Array:
    """What a limit cuts of a half wave whose peak is half a usual step above it."""
    wave = 1.0 + 0.5 * DIFFERENCE_STEP - np.linspace(-1.0, 1.0, 2001) ** 2
    return np.maximum(wave - 1.0 - move, 0.0)


def straight(move: float) -> Array:
    return np.full(100, move)


def rough(move: float) -> Array:
    """A straight response whose last digits fall anew at each move."""
    rng = np.random.default_rng(int(1e9 * abs(move)))
    return move + 0.3 * DIFFERENCE_STEP * rng.standard_normal(100)


def steps_after(response: Callable[[float], Array], hypothesis: Hypothesis) -> dict[str, float]:
    found = with_finer_steps(hypothesis, X, SHOWN, judged_by(response))
    return dict(found.setting.difference_steps)


def test_a_step_that_shows_as_much_as_it_may_stays() -> None:
    shown = np.array([20.0, 59.0])
    assert with_finer_steps(HYPOTHESIS, X, shown, judged_by(cut)) is HYPOTHESIS


def test_a_limit_that_is_gone_within_a_step_gets_a_finer_one() -> None:
    assert steps_after(cut, HYPOTHESIS) == {LIMIT: pytest.approx(0.1 * DIFFERENCE_STEP)}


@pytest.mark.parametrize("response", [straight, rough])
def test_a_straight_or_rough_response_keeps_its_step(response: Callable[[float], Array]) -> None:
    assert steps_after(response, HYPOTHESIS) == {LIMIT: DIFFERENCE_STEP}


def test_a_step_is_judged_once() -> None:
    found = with_finer_steps(HYPOTHESIS, X, SHOWN, judged_by(cut))
    assert with_finer_steps(found, X, SHOWN, judged_by(cut)) is found
