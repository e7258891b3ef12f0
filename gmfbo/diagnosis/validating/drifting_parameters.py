"""Parameters of the twin that differ from recording to recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2 as chi2_distribution

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.evidence import grams
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.numbers import OWN_SPREAD
from gmfbo.diagnosis.comparison.own_parts import by_recording
from gmfbo.diagnosis.comparison.priors import values_at
from gmfbo.diagnosis.naming.decision import Compared

Array = NDArray[np.float64]

_CHANCE = 1e-4  # that an even parameter is told so, before it is shared among parameters


def drifts_of(case: Case, compared: Compared, row: Fitted) -> dict[str, dict[str, float]]:
    """Value of each drifting parameter in each recording.

    A parameter has an own part in each recording, by the parabola about the fit. It drifts if
    these differ by more than chance (Wald 1943), and by more than is usual. What is told are the
    values at which the recordings were simulated, where the model has such.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    compared : Compared
        The comparison that the model comes from.
    row : Fitted
        The model, fitted to all recordings.

    Returns
    -------
    dict of str to dict of str to float
        [FMU's unit] By parameter, then by recording, in their order; none where nothing drifts.
    """
    records = case.simulations.records
    uncertain = row.hypothesis.setting.uncertain
    if len(records) < 2 or not uncertain:
        return {}
    matrices, products, inflation = _of_recordings(compared, row)
    found = {}
    for i, one in enumerate(uncertain):
        if one.name in row.freed:
            continue
        parts, spread = own_parts(matrices, products, row.curvatures, row.slopes, i)
        spread = spread * inflation
        contrasts = np.eye(len(parts))[1:] - np.eye(len(parts))[:-1]
        steps = contrasts @ parts
        statistic = float(steps @ np.linalg.solve(contrasts @ spread @ contrasts.T, steps))
        if chi2_distribution.sf(statistic, len(steps)) > _CHANCE / len(uncertain):
            continue
        if row.own.size and row.own[:, i].any():
            changes = row.own[:, i]
        else:
            # What hardly shows in a recording says nothing of its value there.
            changes = parts - 1.0 / np.diag(spread) @ parts / np.sum(1.0 / np.diag(spread))
        values = [_value(row, i, float(change)) for change in changes]
        if max(values) - min(values) > OWN_SPREAD * abs(float(row.x[i])):
            found[one.name] = dict(zip((r.name for r in records), values, strict=True))
    return found


def _of_recordings(compared: Compared, row: Fitted) -> tuple[Array, Array, float]:
    """Inner products by recording, and by how much the residual is more than noise."""
    search, ledger = compared.search, compared.ledger
    plain = replace(ledger.errors, spreads={})
    whitening = search.noise.whitening(row, ledger.kernels, ledger.levels, plain)
    matrices, products = by_recording(search.problem, grams(search.problem, whitening, row))
    z = row.beside_own_parts(ledger.whitening)(row.residual)
    size = sum(np.count_nonzero(one) for one in z)
    square = sum(float(np.sum(one**2)) for one in z)
    return matrices, products, max(square / max(size, 1), 1.0)


def own_parts(
    matrices: Array, products: Array, curvatures: Array, slopes: Array, place: int
) -> tuple[Array, Array]:
    """Own part of one quantity in each recording, and their covariance; all else is common.

    Parameters
    ----------
    matrices : ndarray, shape (n_recordings, c, c)
        Inner products of the whitened columns.
    products : ndarray, shape (n_recordings, c)
        Of the columns with the residual.
    curvatures, slopes : ndarray, shape (c,)
        Of the negative log prior.
    place : int
        Which quantity.

    Returns
    -------
    tuple of ndarray, shapes (n_recordings,) and (n_recordings, n_recordings)
    """
    rest = [k for k in range(curvatures.size) if k != place]
    common = matrices.sum(0)[np.ix_(rest, rest)] + np.diag(curvatures[rest])
    cross = matrices[:, place][:, rest]
    own = np.diag(matrices[:, place, place] + curvatures[place] / len(matrices))
    turn = np.linalg.solve(common, cross.T)
    information = own - cross @ turn
    slope = products[:, place] - slopes[place] / len(matrices)
    slope = slope - (products.sum(0) - slopes)[rest] @ turn
    spread = np.linalg.pinv(information, hermitian=True).astype(np.float64)
    return spread @ slope, spread


def _value(row: Fitted, place: int, change: float) -> float:
    moved = row.u.copy()
    moved[place] += change
    return float(values_at(row.priors, moved)[place])
