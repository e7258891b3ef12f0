"""A right law has the same parameters in each stretch; one bent to all of them does not."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.outside.same_in_all_stretches import inconstant
from gmfbo.diagnosis.runs.simulated import Point
from tests.diagnosis.naming.linear_evidences import ROWS, SETTING, WINDOWS, blocks
from tests.physics.excitations import TYPICAL

Array = NDArray[np.float64]

GROUPS = range(WINDOWS)
SIZE = 5.0
"""Of a column's rows: 10 standard deviations in all four windows."""


def fitted(recorded: Array, columns: Array) -> Fitted:
    """Least-squares fit of the twin's inertia and an effect's level, columns of shape (2, n)."""
    effect = Candidate("coulomb_friction", {"level": 0.1 * TYPICAL.torque})
    solution = np.linalg.lstsq(columns.T, recorded, rcond=None)[0]
    residual = blocks(recorded - columns.T @ solution)
    return Fitted(
        Hypothesis(SETTING, (effect,)), np.ones(2), [], residual, blocks(columns), [[], []]
    )


class LinearMisfit:
    """Simulates a linear model: what it leaves falls along the columns of a fit."""

    def __init__(self, fit: Fitted) -> None:
        self.fit = fit
        self.simulations = self

    def run(self, points: Sequence[Point]) -> list[list[SimpleNamespace]]:
        """One run a point, which holds the parameters alone."""
        level = "coulomb_friction.level"
        sizes = [np.array([p.parameters["inertia"], p.physics[level]]) for p in points]
        return [[SimpleNamespace(finite=True, x=x)] for x in sizes]

    def residual(self, simulated: Sequence[SimpleNamespace]) -> tuple[Array, ...]:
        """What that leaves in each window."""
        change = simulated[0].x - self.fit.x
        pairs = zip(self.fit.residual, self.fit.sensitivity, strict=True)
        return tuple(left - own.T @ change for left, own in pairs)


def found_inconstant(fit: Fitted, groups: Sequence[int]) -> float:
    """What the law loses, by linear runs."""
    return inconstant(LinearMisfit(fit), fit, groups)  # type: ignore[arg-type]


def drawn(seed: int, share_of_window: Array) -> tuple[Array, Array]:
    """Noise, and two columns of which the second has this size in each window."""
    rng = np.random.default_rng(seed)
    columns = rng.standard_normal((2, WINDOWS * ROWS)) * 100.0
    columns[1] *= np.repeat(share_of_window, ROWS)
    return rng.standard_normal(WINDOWS * ROWS), columns


def test_noise_alone_never_makes_a_right_law_inconstant() -> None:
    for seed in range(300):
        noise, columns = drawn(seed, np.ones(WINDOWS))
        truth = SIZE * columns[1] / np.linalg.norm(columns[1])
        assert found_inconstant(fitted(truth + noise, columns), GROUPS) == 0.0


def test_an_effect_that_changes_its_size_between_stretches_is_inconstant() -> None:
    noise, columns = drawn(0, np.ones(WINDOWS))
    size = np.repeat([1.0, 1.0, -1.0, -1.0], ROWS)
    found = fitted(0.02 * size * columns[1] + noise, columns)
    by_hand = 0.0
    prior = np.diag(np.sqrt(found.prior))
    for g in GROUPS:
        others = np.concatenate([found.sensitivity[i] for i in GROUPS if i != g], axis=1)
        left = np.concatenate([found.residual[i] for i in GROUPS if i != g])
        rows, right = np.vstack([others.T, prior]), np.concatenate([left, np.zeros(2)])
        change = np.linalg.lstsq(rows, right, rcond=None)[0]
        after = found.residual[g] - found.sensitivity[g].T @ change
        by_hand += float(after @ after - found.residual[g] @ found.residual[g])
    assert by_hand > 100.0
    assert found_inconstant(found, GROUPS) == pytest.approx(by_hand, rel=1e-6)


def test_what_one_stretch_alone_shows_speaks_for_nothing() -> None:
    """Fitted without that stretch, the effect may have any size there."""
    noise, columns = drawn(1, np.array([1.0, 1e-3, 1e-3, 1e-3]))
    truth = 100.0 * columns[1] / np.linalg.norm(columns[1])
    assert found_inconstant(fitted(truth + noise, columns), GROUPS) == 0.0


def test_one_group_has_no_others() -> None:
    noise, columns = drawn(2, np.ones(WINDOWS))
    assert found_inconstant(fitted(noise, columns), [0] * WINDOWS) == 0.0
