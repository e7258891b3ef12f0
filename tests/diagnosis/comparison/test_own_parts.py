"""Spreads of own parts, against the density of all recordings at once."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gmfbo.diagnosis.comparison.own_parts import (
    eliminated,
    restricted,
    spreads,
    usual_spreads,
)
from gmfbo.diagnosis.comparison.priors import Prior

ROWS = 60
PLACES = np.array([0, 1])


def recordings(spread: float, seed: int, count: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """Columns (count, 3, rows) and residuals (count, rows) of noise 1."""
    rng = np.random.default_rng(seed)
    columns = rng.standard_normal((count, 3, ROWS))
    own = spread * rng.standard_normal(count)
    return columns, own[:, None] * columns[:, 0] + rng.standard_normal((count, ROWS))


def grams(columns: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return (
        np.einsum("rin,rjn->rij", columns, columns),
        np.einsum("rin,rn->ri", columns, residual),
    )


def dense(columns: np.ndarray, residual: np.ndarray, sizes: np.ndarray) -> float:
    """Log density of all residuals: common values with unit priors, own parts, noise."""
    count = len(columns)
    common = columns.transpose(1, 0, 2).reshape(3, -1)
    cov = np.eye(count * ROWS) + common.T @ common
    for r in range(count):
        rows = slice(r * ROWS, (r + 1) * ROWS)
        own = columns[r, PLACES] * sizes[:, None]
        cov[rows, rows] += own.T @ own
    z = residual.ravel()
    return -0.5 * float(z @ np.linalg.solve(cov, z)) - 0.5 * float(np.linalg.slogdet(cov)[1])


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000), st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 2.0)))
def test_density_is_that_of_all_recordings_at_once(seed: int, pair: tuple[float, float]) -> None:
    columns, residual = recordings(0.5, seed)
    inner, sizes = grams(columns, residual), np.array(pair)
    found = [
        restricted(*inner, np.ones(3), np.zeros(3), PLACES, size) for size in (sizes, 0.0 * sizes)
    ]
    exact = [dense(columns, residual, size) for size in (sizes, 0.0 * sizes)]
    assert found[0] - found[1] == pytest.approx(exact[0] - exact[1], abs=1e-6)


def test_a_spread_is_recovered() -> None:
    columns, residual = recordings(0.6, 5, count=40)
    found = spreads(*grams(columns, residual), np.ones(3), np.zeros(3), PLACES, np.full(2, 0.5))
    assert found[0] == pytest.approx(0.6, rel=0.3)
    assert found[1] < 0.1


def test_an_even_quantity_has_none_or_little() -> None:
    """Negative control: a spread of no more than a value of one recording is uncertain by."""
    found = []
    for seed in range(20):
        inner = grams(*recordings(0.0, seed, count=5))
        found.append(spreads(*inner, np.ones(3), np.zeros(3), PLACES, np.full(2, 0.5)))
    assert np.mean(np.array(found) == 0.0) > 0.5
    assert np.max(found) < 2.0 / np.sqrt(ROWS)


def test_without_quantities_there_are_no_spreads() -> None:
    none = np.zeros(0)
    found = spreads(np.zeros((4, 0, 0)), np.zeros((4, 0)), none, none, [], none)
    assert found.size == 0


def test_of_one_recording_no_spread_is_learned() -> None:
    """Common and own part are the same there: only the prior speaks."""
    columns, residual = recordings(0.0, 7, count=1)
    residual = residual + 3.0 * columns[:, 0]
    found = spreads(
        *grams(columns, residual), np.full(3, 1e-6), np.zeros(3), PLACES, np.full(2, 0.5)
    )
    np.testing.assert_allclose(found, 0.0)


def test_a_step_and_own_parts_are_those_of_one_joint_fit() -> None:
    columns, residual = recordings(0.8, 11, count=4)
    count, sizes = len(columns), np.array([0.5, 0.2])
    left = eliminated(*grams(columns, residual), PLACES, sizes)
    step = np.linalg.solve(left.matrix + np.eye(3), left.product).astype(np.float64)
    design = np.zeros((count, ROWS, 3 + 2 * count))
    for r in range(count):
        design[r, :, :3] = columns[r].T
        design[r, :, 3 + 2 * r : 5 + 2 * r] = columns[r, PLACES].T
    flat = design.reshape(count * ROWS, -1)
    prior = np.diag(np.concatenate([np.ones(3), np.tile(sizes**-2, count)]))
    joint = np.linalg.solve(flat.T @ flat + prior, flat.T @ residual.ravel())
    np.testing.assert_allclose(step, joint[:3], rtol=1e-9)
    np.testing.assert_allclose(left.parts(step).ravel(), joint[3:], rtol=1e-8)


def test_the_gain_of_own_parts_is_what_a_joint_fit_gains_by_them() -> None:
    columns, residual = recordings(0.8, 12, count=3)
    sizes, began = np.array([0.5, 0.2]), np.full((3, 2), 0.1)
    left = eliminated(*grams(columns, residual), PLACES, sizes)

    def cost(parts: np.ndarray) -> float:
        made = np.einsum("rk,rkn->rn", parts, columns[:, PLACES])
        return 0.5 * float(np.sum((residual - made) ** 2) + np.sum((parts / sizes) ** 2))

    best = left.parts(np.zeros(3))
    assert left.gain(began) == pytest.approx(cost(began) - cost(best))
    assert left.gain(best) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("damping", [0.0, 0.3, 1.0, 10.0, 100.0])
def test_what_a_damped_step_promises_beside_own_parts_comes_true(damping: float) -> None:
    columns, residual = recordings(0.8, 13, count=3)
    sizes, began = np.array([0.5, 0.2]), np.full((3, 2), 0.1)
    left = eliminated(*grams(columns, residual), PLACES, sizes)
    a, g = left.matrix + np.eye(3), left.product
    step = np.linalg.solve(a + damping * np.diag(np.diag(a)), g).astype(np.float64)

    def cost(common: np.ndarray, parts: np.ndarray) -> float:
        made = np.einsum("i,rin->rn", common, columns)
        made = made + np.einsum("rk,rkn->rn", parts, columns[:, PLACES])
        squares = np.sum((residual - made) ** 2) + np.sum((parts / sizes) ** 2)
        return 0.5 * float(squares + common @ common)

    fall = cost(np.zeros(3), began) - cost(step, left.moved(began, step, damping))
    promised = g @ step - 0.5 * step @ a @ step + left.gain(began, damping)
    assert fall == pytest.approx(promised, abs=1e-9)
    assert fall > 0.0


def test_lines_and_what_is_fixed_have_no_own_part() -> None:
    """A line whose own parts were half of it made friction over position of one that grew."""
    priors = (
        Prior(0.1, 10.0, True, "normal", 0.0, 1.0),
        Prior(0.1, 10.0, True, "normal", 0.0, 1.0),
        Prior(0.0, 5.0, False, "cauchy", 0.0, 1.0),
        Prior(0.5, 500.0, False, "uniform", 0.0, 0.0),
    )
    fitted = SimpleNamespace(
        hypothesis=SimpleNamespace(names=("inertia", "filter_time", "level", "wavenumber")),
        freed=("filter_time",),
        priors=priors,
        u=np.array([0.0, 0.0, 2.0, 40.0]),
    )
    inertia, filter_time, level, wavenumber = usual_spreads(cast(Any, fitted))
    assert inertia > 0.0
    assert level > 0.0
    assert filter_time == wavenumber == 0.0
