"""Own parts of a parameter in each recording, against least squares of each alone."""

from __future__ import annotations

import numpy as np

from gmfbo.diagnosis.validating.drifting_parameters import own_parts

COUNT, ROWS = 5, 400


def regression(own: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inner products about zero of recordings whose first value differs, and the columns."""
    rng = np.random.default_rng(seed)
    columns = rng.standard_normal((COUNT, 3, ROWS))
    residual = own[:, None] * columns[:, 0] + 0.3 * columns[:, 1] + rng.standard_normal(ROWS)
    return (
        np.einsum("rin,rjn->rij", columns, columns),
        np.einsum("rin,rn->ri", columns, residual),
        np.concatenate([columns.transpose(1, 0, 2), residual[None]]),
    )


def test_own_parts_are_those_of_one_joint_regression() -> None:
    truth = np.array([0.5, 0.4, 0.0, -0.3, -0.6])
    matrices, products, rows = regression(truth, 1)
    parts, spread = own_parts(matrices, products, np.zeros(3), np.zeros(3), 0)
    own = np.zeros((COUNT, COUNT, ROWS))
    own[np.arange(COUNT), np.arange(COUNT)] = rows[0]
    design = np.concatenate([own, rows[1:3]]).reshape(COUNT + 2, -1).T
    exact, *_ = np.linalg.lstsq(design, rows[3].ravel(), rcond=None)
    np.testing.assert_allclose(parts, exact[:COUNT], rtol=1e-9)
    np.testing.assert_allclose(spread, np.linalg.inv(design.T @ design)[:COUNT, :COUNT], rtol=1e-8)
    assert np.all(np.abs(parts - truth) < 4.0 * np.sqrt(np.diag(spread)))


def test_parts_of_an_even_parameter_differ_by_no_more_than_chance() -> None:
    """Negative control."""
    matrices, products, _ = regression(np.full(COUNT, 0.2), 2)
    parts, spread = own_parts(matrices, products, np.zeros(3), np.zeros(3), 0)
    steps, contrasts = np.diff(parts), np.diff(np.eye(COUNT), axis=0)
    assert steps @ np.linalg.solve(contrasts @ spread @ contrasts.T, steps) < 20.0
