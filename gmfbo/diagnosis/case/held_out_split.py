"""Split recordings into stretches that are fitted and stretches that are only scored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.linear_left_out import normal_equations, solve_weakly_bound
from gmfbo.diagnosis.fitting.misfit import Blocks, Misfit

_WHOLE_FROM = 3  # recordings, from which whole ones are held out
_SHARE = 0.3  # of the recordings
_LESS_SURE = 3.0  # times the standard deviation that all recordings leave of a value


@dataclass(frozen=True)
class Split:
    """Windows of a case, split into fitted and held-out ones.

    Attributes
    ----------
    fitted, held_out : tuple of int
        Indices of windows.
    names_fitted, names_held_out : tuple of str
        Recordings, with the stretch of time where one is cut.
    """

    fitted: tuple[int, ...]
    held_out: tuple[int, ...]
    names_fitted: tuple[str, ...]
    names_held_out: tuple[str, ...]


def split_of(case: Case, changes: Sequence[Blocks], model: Fitted) -> Split:
    """Hold out whole recordings where there are three, else the last stretch of each.

    Held-out recordings show the named physics well, so that their score means something. The
    recording that shows an effect best stays in the fit: it may be the only one that tells the
    size. So does a recording without which a parameter would be undetermined, such as one of two
    speeds that together determine a speed-dependent limit.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    changes : sequence of Blocks
        Whitened change of the signals by each named effect, in the order of naming.
    model : Fitted
        The twin with all named effects, fitted to all recordings.
    """
    windows, records = case.budget.windows, case.simulations.records
    scored = scored_records(case)
    if len(scored) >= _WHOLE_FROM:
        out = _whole_recordings(case, changes, model)
        fitted = tuple(i for i, w in enumerate(windows) if w.record not in out)
        held = tuple(i for i, w in enumerate(windows) if w.record in out)
        return Split(
            fitted,
            held,
            tuple(records[k].name for k in scored if k not in out),
            tuple(records[k].name for k in scored if k in out),
        )
    last = {w.record: i for i, w in enumerate(windows)}
    held = tuple(
        i for i in last.values() if sum(w.record == windows[i].record for w in windows) > 1
    )
    fitted = tuple(i for i in range(len(windows)) if i not in held)
    return Split(fitted, held, _stretches(case, fitted), _stretches(case, held))


def _whole_recordings(case: Case, changes: Sequence[Blocks], model: Fitted) -> set[int]:
    """Recordings to hold out: at least one, and more while no parameter becomes uncertain."""
    scored = scored_records(case)
    records = [scored.index(window.record) for window in case.budget.windows]
    count = len(scored)
    strengths = np.zeros((max(len(changes), 1), count))
    for strength, change in zip(strengths, changes, strict=False):
        for record, block in zip(records, change, strict=True):
            strength[record] += float(block @ block)
    order = np.argsort(-strengths.sum(axis=0), kind="stable").tolist()
    best = [int(np.argmax(strength)) for strength in strengths]
    others = [k for k in order if k not in best] or [k for k in order if k != best[0]]
    matrices = normal_equations(model.residual, model.sensitivity, records).matrix
    known = _variances(matrices.sum(axis=0), model.prior)

    def doubt_without(out: set[int]) -> float:
        """Largest factor by which a parameter's standard deviation grows without these."""
        kept = [k for k in range(count) if k not in out]
        lost = _variances(matrices[kept].sum(axis=0), model.prior) / known
        return float(np.sqrt(np.max(lost, initial=1.0)))

    out: set[int] = set()
    while len(out) < min(len(others), max(1, round(_SHARE * count))):
        left = [k for k in others if k not in out]
        doubts = {k: doubt_without(out | {k}) for k in left}
        foretold = [k for k in left if doubts[k] < _LESS_SURE]
        if out and not foretold:
            break
        out.add(foretold[0] if foretold else min(left, key=lambda k: doubts[k]))
    return {scored[k] for k in out}


def scored_records(case: Case) -> list[int]:
    """Places of the recordings that have a window: others end before their start is forgotten."""
    return sorted({window.record for window in case.budget.windows})


def _variances(matrix: NDArray[np.float64], prior: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.diag(solve_weakly_bound(matrix, np.eye(prior.size), prior))


def restricted(misfit: Misfit, chosen: Sequence[int]) -> Misfit:
    """Misfit of some of the windows."""
    return replace(misfit, whiteners=tuple(misfit.whiteners[i] for i in chosen))


def rows_of(case: Case, chosen: Sequence[int], record: int, signal: int) -> NDArray[np.int64]:
    """Rows of one signal that lie in the chosen windows."""
    pieces = [
        np.arange(w.rows[signal].start, w.rows[signal].stop)
        for w in (case.budget.windows[i] for i in chosen)
        if w.record == record
    ]
    return np.concatenate(pieces) if pieces else np.zeros(0, dtype=np.int64)


def _stretches(case: Case, chosen: Sequence[int]) -> tuple[str, ...]:
    names = []
    for k, record in enumerate(case.simulations.records):
        rows = rows_of(case, chosen, k, 0)
        if not rows.size:
            continue
        time = record.signals[0].time
        if rows.size == time.size:
            names.append(record.name)
        else:
            names.append(f"{record.name} [{time[rows[0]]:.3g}, {time[rows[-1]]:.3g}] s")
    return tuple(names)
