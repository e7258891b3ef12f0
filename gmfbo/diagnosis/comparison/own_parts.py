"""Own parts of a model's quantities in each recording: rigs warm up, and loads change.

A quantity has a common value, and in each recording a part of its own whose spread is learned. What
such parts make of the signals is known from the fit's columns, and is no missing physics.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from gmfbo.diagnosis.comparison.evidence import Grams, grams
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.numbers import OWN_SPREAD
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening

Array = NDArray[np.float64]

_STARTS = (0.1, 1.0)  # of the prior's mean, where a search for the spreads begins
_MOST = 10.0  # of the prior's mean
_NONE = 1e-2  # of the prior's mean: a smaller spread is none


def own_spreads(problem: Problem, whitening: Whitening, fitted: Fitted) -> dict[str, float]:
    """Learn the spread of each free quantity over the recordings, where there is any.

    Quantities that a twin file holds fixed have no own part, nor have lines, times and stiffnesses.

    Parameters
    ----------
    problem : Problem
        Recordings.
    whitening : Whitening
        By all but own parts.
    fitted : Fitted
        A hypothesis at its best values, with its columns.

    Returns
    -------
    dict of str to float
        In the coordinates of the quantities' priors.
    """
    if not fitted.columns or len({segment.record for segment in problem.segments}) < 2:
        return {}
    usual = usual_spreads(fitted)
    places = np.flatnonzero(usual)
    matrices, products = by_recording(problem, grams(problem, whitening, fitted))
    sizes = spreads(matrices, products, fitted.curvatures, fitted.slopes, places, usual[places])
    names = fitted.hypothesis.names
    return {names[i]: float(size) for i, size in zip(places, sizes, strict=True) if size > 0.0}


def usual_spreads(fitted: Fitted) -> Array:
    """Mean of the prior of each own part's spread, shape (p,), in the quantities' coordinates.

    Lines, times and stiffnesses of a law have none: a machine's geometry is the same in each run.

    Parameters
    ----------
    fitted : Fitted
        A hypothesis at its best values.
    """
    names = fitted.hypothesis.names
    own = [
        OWN_SPREAD * (1.0 if prior.logarithmic else abs(u))
        if name not in fitted.freed and prior.kind != "uniform"
        else 0.0
        for name, prior, u in zip(names, fitted.priors, fitted.u, strict=True)
    ]
    return np.array(own)


def without_own_parts(
    problem: Problem, residual: Sequence[Array], columns: Sequence[Array], own: Array
) -> list[Array]:
    """[SI] A residual as it is at the common values, as columns show it, by segment.

    Parameters
    ----------
    problem : Problem
        Recordings.
    residual : sequence of ndarray, shape (m, n)
        [SI] With own parts.
    columns : sequence of ndarray, shape (p or more, m, n)
        [SI] Change of the signals per unit of each quantity.
    own : ndarray, shape (n_recordings, p)
        Own parts; empty where there are none.
    """
    if not own.any():
        return list(residual)
    parts = zip(problem.segments, residual, columns, strict=True)
    p = own.shape[1]
    return [z + np.tensordot(own[s.record], c[:p], 1) for s, z, c in parts]


def by_recording(problem: Problem, inner: Grams) -> tuple[Array, Array]:
    """Inner products of a fit's columns, and of these with its residual, by recording."""
    owners = np.array(
        [
            segment.record
            for segment, stretches in zip(problem.segments, problem.stretches(), strict=True)
            for _ in stretches
        ]
    )
    at = (owners[:, None] == np.arange(len(problem.simulations.records))).astype(float)
    return (
        np.einsum("sr,sij->rij", at, inner.matrices),
        np.einsum("sr,si->ri", at, inner.products),
    )


def spreads(
    matrices: Array,
    products: Array,
    curvatures: Array,
    slopes: Array,
    places: Sequence[int] | NDArray[np.intp],
    usual: Array,
) -> Array:
    """Most probable spreads of own parts, shape (k,), all values integrated out.

    The restricted likelihood of variance components (Patterson and Thompson 1971), with an
    exponential prior of each spread (Simpson and others 2017).

    Parameters
    ----------
    matrices : ndarray, shape (n_recordings, c, c)
        Inner products of the whitened columns.
    products : ndarray, shape (n_recordings, c)
        Of the columns with the residual.
    curvatures, slopes : ndarray, shape (c,)
        Of the negative log prior of the common values.
    places : sequence of int, length k
        Quantities that have own parts.
    usual : ndarray, shape (k,)
        Mean of each spread's prior.
    """
    places = np.asarray(places, dtype=np.intp)

    def cost(ratios: Array) -> float:
        size = ratios * usual
        return float(ratios.sum()) - restricted(
            matrices, products, curvatures, slopes, places, size
        )

    zero = np.zeros(places.size)
    if not places.size:
        return zero
    best, least = zero, cost(zero)
    for start in _STARTS:
        found = minimize(
            cost, np.full(places.size, start), method="L-BFGS-B", bounds=[(0.0, _MOST)] * len(zero)
        )
        ratios = np.where(found.x < _NONE, 0.0, found.x)
        value = cost(ratios)
        if value < least:
            best, least = ratios, value
    return best * usual


def restricted(
    matrices: Array,
    products: Array,
    curvatures: Array,
    slopes: Array,
    places: NDArray[np.intp],
    sizes: Array,
) -> float:
    """[nats] Log density of the residuals under own parts of some spreads, less a constant.

    Parameters
    ----------
    matrices, products, curvatures, slopes, places
        As of `spreads`.
    sizes : ndarray, shape (k,)
        Spread of each own part.
    """
    left = eliminated(matrices, products, places, sizes)
    a, g = left.matrix + np.diag(curvatures), left.product - slopes
    return float(left.density + 0.5 * g @ np.linalg.solve(a, g) - 0.5 * np.linalg.slogdet(a)[1])


@dataclass(frozen=True, eq=False)
class Eliminated:
    """Normal equations of common values, own parts eliminated from them.

    Attributes
    ----------
    matrix : ndarray, shape (c, c)
        Of the common values, without priors.
    product : ndarray, shape (c,)
        Of the columns with the residual.
    density : float
        [nats] What own parts alone gain, less the volume that they cost.
    scale : ndarray, shape (k,)
        Spread of each own part.
    precision : ndarray, shape (n_recordings, k, k)
        Of own parts in units of their spreads.
    likely : ndarray, shape (n_recordings, k)
        Own parts in these units, beside the common values as they are.
    turned : ndarray, shape (n_recordings, k, c)
        By what these fall per unit of a step of the common values.
    """

    matrix: Array
    product: Array
    density: float
    scale: Array
    precision: Array
    likely: Array
    turned: Array

    def parts(self, step: Array) -> Array:
        """Most likely own parts after a step of the common values, shape (n_recordings, k)."""
        found: Array = (self.likely - self.turned @ step) * self.scale
        return found

    def moved(self, parts: Array, step: Array, damping: float) -> Array:
        """Own parts after a step, shape (n_recordings, k).

        They follow the step in full, as it was made for; what they lacked before is damped.

        Parameters
        ----------
        parts : ndarray, shape (n_recordings, k)
            As they are.
        step : ndarray, shape (c,)
            Of the common values.
        damping : float
            Of Levenberg and Marquardt.
        """
        still = self.parts(np.zeros_like(step))
        found: Array = parts + (still - parts) / (1.0 + damping) + self.parts(step) - still
        return found

    def gain(self, parts: Array, damping: float = 0.0) -> float:
        """[nats] From own parts towards the most likely ones, as far as damping lets them move."""
        short, left = self.likely - parts / self.scale, damping / (1.0 + damping)
        square = np.einsum("rk,rkl,rl->", short, self.precision, short)
        return float(0.5 * (1.0 - left**2) * square)


def eliminated(
    matrices: Array, products: Array, places: NDArray[np.intp], sizes: Array
) -> Eliminated:
    """Eliminate own parts of some spreads from the normal equations of all recordings.

    Parameters
    ----------
    matrices, products, places
        As of `spreads`.
    sizes : ndarray, shape (k,)
        Spread of each own part.
    """
    cross = matrices[:, :, places] * sizes
    inner = np.eye(places.size) + sizes[:, None] * cross[:, places]
    slope = products[:, places] * sizes
    solved = np.linalg.solve(inner, np.concatenate([cross, slope[:, None]], 1).transpose(0, 2, 1))
    turned, likely = solved[:, :, :-1], solved[:, :, -1]
    own = np.einsum("rk,rk->r", slope, likely) - np.linalg.slogdet(inner)[1]
    return Eliminated(
        (matrices - cross @ turned).sum(0),
        (products - np.einsum("rck,rk->rc", cross, likely)).sum(0),
        float(0.5 * own.sum()),
        sizes,
        inner,
        likely,
        turned,
    )


def beside_own_parts_on(
    whitening: Whitening, problem: Problem, whole: Problem, rows: Sequence[Fitted]
) -> Whitening:
    """A whitening of some windows with own parts of fits to all windows beside.

    Parameters
    ----------
    whitening : Whitening
        Of the windows.
    problem : Problem
        The windows; those of other recordings than the fits saw have no own parts.
    whole : Problem
        All windows.
    rows : sequence of Fitted
        Fits to them, with their columns.
    """
    if problem.simulations is not whole.simulations:
        return whitening
    names = [name for row in rows for name in row.hypothesis.names]
    columns = []
    for segment in problem.segments:
        own = [i for i, other in enumerate(whole.segments) if other.record == segment.record]
        time = np.concatenate([whole.segments[i].time for i in own])
        at = np.searchsorted(time, segment.time - 0.5 * segment.spacing).clip(0, time.size - 1)
        seen = np.abs(time[at] - segment.time) < segment.spacing  # rests may be compared here alone
        parts = [
            np.concatenate([row.columns[i][: row.u.size] for i in own], axis=2) for row in rows
        ]
        columns.append(np.concatenate([part[:, :, at] * seen for part in parts]))
    return whitening.about(names, columns)
