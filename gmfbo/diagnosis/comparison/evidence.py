"""Log evidence of fitted hypotheses, under weightings of the stretches of the recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.numbers import BOOTSTRAP_DRAWS
from gmfbo.diagnosis.comparison.priors import bounds_of
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening

Array = NDArray[np.float64]

LEAST_STRETCHES = 3
"""[1] Of which a bootstrap tells a spread."""

_MOST_VALUES = 8_000_000  # of curvatures that are held at a time: 64 MB


@dataclass(frozen=True, eq=False)
class Grams:
    """Inner products of a fit's whitened columns and residual in each stretch.

    Attributes
    ----------
    matrices : ndarray, shape (n_stretches, c, c)
        Of c whitened columns.
    products : ndarray, shape (n_stretches, c)
        Columns with residual.
    squares : ndarray, shape (n_stretches,)
        Of the residual, and the log determinant of its covariance.
    """

    matrices: Array
    products: Array
    squares: Array


def grams(
    problem: Problem,
    whitening: Whitening,
    fitted: Fitted,
    bumps: Sequence[Array] = (),
    *,
    are_free: bool = False,
) -> Grams:
    """Inner products by stretch of a fit's whitened columns, then of bumps beside them.

    Parameters
    ----------
    problem : Problem
        Stretches.
    whitening : Whitening
        By noise.
    fitted : Fitted
        Residual and columns.
    bumps : sequence of ndarray, shape (c, m, n)
        Whitened already, by segment. They are kept orthogonal to what the hypothesis moves
        (Plumlee 2017), so that its values are those that fit best.
    are_free : bool
        The bumps are part of the hypothesis, and stay as they are.
    """
    residual, columns = whitening(fitted.residual), whitening(fitted.columns)
    if are_free:
        columns = [np.concatenate(both) for both in zip(columns, bumps, strict=True)]
    elif len(bumps) and bumps[0].shape[0]:
        a = np.diag(fitted.curvatures)
        cross = np.zeros((len(a), bumps[0].shape[0]))
        for j, bump in zip(columns, bumps, strict=True):
            flat, other = j.reshape(j.shape[0], -1), bump.reshape(bump.shape[0], -1)
            a += flat @ flat.T
            cross += flat @ other.T
        turn = np.linalg.solve(a, cross)
        columns = [
            np.concatenate([j, bump - np.tensordot(turn.T, j, 1)])
            for j, bump in zip(columns, bumps, strict=True)
        ]
    found_a, found_b, found_c = [], [], []
    for z, j, logs, stretches in zip(
        residual, columns, whitening.log_determinants, problem.stretches(), strict=True
    ):
        for rows in stretches:
            flat = j[:, :, rows].reshape(j.shape[0], -1)
            own = z[:, rows].ravel()
            found_a.append(flat @ flat.T)
            found_b.append(flat @ own)
            found_c.append(own @ own + logs[rows].sum())
    return Grams(np.array(found_a), np.array(found_b), np.array(found_c))


def weightings(n_stretches: int, seed: int = 0) -> Array:
    """Bayesian bootstrap weights of the stretches, shape (draws, n_stretches) (Rubin 1981)."""
    rng = np.random.default_rng(seed)
    return n_stretches * rng.dirichlet(np.ones(n_stretches), BOOTSTRAP_DRAWS)


def tilted_parabola(fitted: Fitted, inner: Grams, weights: Array) -> tuple[Array, Array]:
    """A fit's parabola under each weighting of the stretches.

    Parameters
    ----------
    fitted : Fitted
        A hypothesis at its best values.
    inner : Grams
        Of its columns.
    weights : ndarray, shape (n_weightings, n_stretches)
        Of the stretches.

    Returns
    -------
    tuple of ndarray, shapes (n_weightings, c) and (n_weightings, c, c)
        By how much its top lies beside the fit, and its curvature.
    """
    curvature = np.tensordot(weights, inner.matrices, 1) + np.diag(fitted.curvatures)
    slopes = weights @ inner.products - fitted.slopes
    moved = np.linalg.solve(curvature, slopes[:, :, None])[:, :, 0]
    return np.asarray(moved, dtype=np.float64), curvature


def log_evidences(
    fitted: Fitted, inner: Grams, weights: Array, extra: int = 0, size: float = 0.0
) -> Array:
    """Log evidence under each weighting, shape (n_weightings,).

    The log density is a parabola about the fit whose curvature and slope are sums over stretches
    (Laplace's method; Huggins and Miller 2023 for the weightings).

    Parameters
    ----------
    fitted : Fitted
        A hypothesis at its best values.
    inner : Grams
        Of its columns, then of `extra` columns of an inadequacy.
    weights : ndarray, shape (n_weightings, n_stretches)
        Of the stretches.
    extra : int
        Number of columns of the inadequacy.
    size : float
        Standard deviation of their amplitudes; without it they do not count.
    """
    p = fitted.u.size + fitted.nuisances.size
    count = p + (extra if size > 0.0 else 0)
    most = max(1, _MOST_VALUES // count**2) if count else len(weights)
    if len(weights) > most:
        parts = np.split(weights, range(most, len(weights), most))
        return np.concatenate([log_evidences(fitted, inner, w, extra, size) for w in parts])
    curvature = np.concatenate([fitted.curvatures, np.full(count - p, size**-2 if size else 0.0)])
    unit = 1.0 / np.sqrt(curvature)  # in units of the priors no eigenvalue is below one
    a = np.tensordot(weights, inner.matrices[:, :count, :count], 1)
    a = a * unit[:, None] * unit + np.eye(count)
    g = weights @ inner.products[:, :count]
    g[:, :p] -= fitted.slopes
    factor = np.linalg.cholesky(a)
    logs = 2.0 * np.log(np.einsum("bii->bi", factor)).sum(1) + np.log(curvature).sum()
    # Quantities that rest at a bound do not move.
    moves = np.ones(count, dtype=bool)
    moves[:p] = ~np.concatenate([_at_bounds(fitted), fitted.at_zero])
    if not moves.all():
        factor = np.linalg.cholesky(a[:, moves][:, :, moves])
    shift = np.linalg.solve(factor, (g * unit)[:, moves, None])[:, :, 0]
    total = -0.5 * weights @ inner.squares + 0.5 * np.sum(shift**2, axis=1) - 0.5 * logs
    total += fitted.log_prior + 0.5 * count * np.log(2.0 * np.pi)
    if count > p:
        total -= (count - p) * (np.log(size) + 0.5 * np.log(2.0 * np.pi))
    inside: Array = total + _inside(fitted, inner, count, curvature)
    return inside


def _at_bounds(fitted: Fitted) -> NDArray[np.bool_]:
    ends = bounds_of(fitted.priors)
    near = 1e-5 * (ends[:, 1] - ends[:, 0])
    held: NDArray[np.bool_] = (fitted.u <= ends[:, 0] + near) | (fitted.u >= ends[:, 1] - near)
    return held


def _inside(fitted: Fitted, inner: Grams, count: int, curvature: Array) -> float:
    """[nats] Share of the parabola's mass that lies within the bounds of each quantity."""
    if not fitted.u.size:
        return 0.0
    a = inner.matrices[:, :count, :count].sum(0) + np.diag(curvature)
    widths = np.sqrt(np.diag(np.linalg.inv(a)))[: fitted.u.size]
    ends = bounds_of(fitted.priors)
    room = np.minimum(fitted.u - ends[:, 0], ends[:, 1] - fitted.u) / widths
    return float(log_ndtr(room).sum())
