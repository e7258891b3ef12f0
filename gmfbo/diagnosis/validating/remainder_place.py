"""On what the remainder depends that no law explains, and where it shows."""

from __future__ import annotations

from collections.abc import Sequence
from math import log

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.evidence import Grams, grams, log_evidences
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.inadequacy import inadequacy_columns, with_inadequacy
from gmfbo.diagnosis.comparison.numbers import NAMED
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.naming.decision import Compared
from gmfbo.diagnosis.result.explained import Remainder
from gmfbo.plain_words import number

Array = NDArray[np.float64]


def remainder_of(case: Case, compared: Compared, row: Fitted, share: float) -> Remainder:
    """Describe what a model leaves beyond noise.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    compared : Compared
        The comparison that the model comes from.
    row : Fitted
        The model.
    share : float
        Of what the refitted twin leaves beyond noise.
    """
    whitening = row.beside_own_parts(compared.search.noise.quiet(row, compared.ledger))
    against = _state(compared, row, whitening)
    port = None if against is None else "torque"
    return Remainder(share, port, against, _where(case, compared, row, whitening))


def _state(compared: Compared, row: Fitted, whitening: Whitening) -> str | None:
    """State of which a smooth torque explains most, where it is told from none at 0.95."""
    search, kernels = compared.search, compared.ledger.kernels
    bumps = inadequacy_columns(search.problem, kernels, row)
    extra = bumps[0].shape[0] // 2
    if not extra:
        return None
    inner = grams(search.problem, whitening, row, whitening(bumps))
    count = inner.matrices.shape[1] - 2 * extra
    once = np.ones((1, inner.squares.size))
    alone = float(log_evidences(row, _chosen(inner, range(count)), once)[0])
    gains = {}
    for k, state in enumerate(("velocity", "position")):
        first = count + k * extra
        chosen = _chosen(inner, [*range(count), *range(first, first + extra)])
        gains[state] = float(with_inadequacy(row, chosen, once, extra, search.tolerance)[0][0])
    best = max(gains, key=lambda state: gains[state])
    return best if gains[best] - alone > log(NAMED / (1.0 - NAMED)) else None


def _chosen(inner: Grams, places: Sequence[int]) -> Grams:
    where = list(places)
    return Grams(inner.matrices[:, where][:, :, where], inner.products[:, where], inner.squares)


def _where(case: Case, compared: Compared, row: Fitted, whitening: Whitening) -> str:
    """Stretch that holds more than half of what is more than noise."""
    problem, whitened = compared.search.problem, whitening(row.residual)
    squares = problem.by_stretch([z**2 for z in whitened])
    noise = problem.by_stretch([(z != 0.0).astype(float) for z in whitened])
    excess = np.concatenate(squares) - np.concatenate(noise)
    names = []
    for segment, stretches in zip(problem.segments, problem.stretches(), strict=True):
        recording = case.simulations.records[segment.record].name
        for rows in stretches:
            first, last = segment.time[rows][[0, -1]]
            names.append(f"{recording} {number(float(first))}-{number(float(last))} s")
    most = int(np.argmax(excess))
    return names[most] if excess[most] > 0.5 * max(float(excess.sum()), 0.0) else "throughout"
