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
SHOWN = {LIMIT: 200.0}  # the finer step is a tenth of the usual one


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


def rough(size: float, seed: int) -> Callable[[float], Array]:
    """A straight response whose last digits fall anew at each move."""

    def response(move: float) -> Array:
        rng = np.random.default_rng([seed, int(1e9 * abs(move))])
        return move + size * DIFFERENCE_STEP * rng.standard_normal(100)

    return response


def steps_after(response: Callable[[float], Array], hypothesis: Hypothesis) -> dict[str, float]:
    found = with_finer_steps(hypothesis, X, SHOWN, judged_by(response))
    return dict(found.setting.difference_steps)


def test_a_limit_that_is_gone_within_a_step_gets_a_finer_one() -> None:
    assert steps_after(cut, HYPOTHESIS) == {LIMIT: pytest.approx(0.1 * DIFFERENCE_STEP)}


def test_a_straight_response_keeps_its_step() -> None:
    assert steps_after(straight, HYPOTHESIS) == {}


@pytest.mark.parametrize("size", [0.3, 3.0, 100.0])
def test_a_rough_response_keeps_its_step(size: float) -> None:
    found = [steps_after(rough(size, seed), HYPOTHESIS) for seed in range(50)]
    assert not any(found)


def test_a_step_that_was_shortened_is_not_judged_again() -> None:
    found = with_finer_steps(HYPOTHESIS, X, SHOWN, judged_by(cut))
    assert with_finer_steps(found, X, SHOWN, judged_by(straight)) is found
