"""On what the remainder depends that no law explains, and where it shows."""

from __future__ import annotations

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.naming.decision import Compared, Decision
from gmfbo.diagnosis.result.explained import Remainder
from gmfbo.diagnosis.validating.resembled_law import resembled_law
from gmfbo.plain_words import number


def remainder_of(case: Case, decision: Decision, share: float) -> Remainder:
    """Describe what a model leaves beyond noise.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        The model, and what acts beside it.
    share : float
        Of what the refitted twin leaves beyond noise.
    """
    compared, row, unknown = decision.compared, decision.row, decision.unknown
    whitening = row.beside_own_parts(compared.search.noise.quiet(row, compared.ledger))
    where = _where(case, compared, row, whitening)
    if unknown is None:
        return Remainder(share, None, None, where)
    instead = decision.stand_ins
    likely = None if instead else resembled_law(compared, unknown)
    return Remainder(share, unknown.port, unknown.against, where, likely, instead)


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
