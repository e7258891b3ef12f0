"""The twin's own encoder counts, and the values of its parameters that leave none."""

from __future__ import annotations

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.problem import EncoderCounts
from gmfbo.diagnosis.comparison.starting.finer_counts import ENOUGH, FINER, times
from gmfbo.diagnosis.comparison.starting.fixed_parameters import SMALL_CHANGE, changeable
from gmfbo.diagnosis.comparison.starting.hidden_counts import hidden_counts
from gmfbo.diagnosis.runs.quantum import resolution
from gmfbo.diagnosis.runs.simulated import Point

_UNLIKE = 0.1  # by which the power of the parameter in a count may differ from 1 or -1
_MOST = 4  # encoders that nobody sees


def encoder_counts(case: Case) -> EncoderCounts | None:
    """How to simulate the twin without the counts of its encoders; None where that is not known.

    Two runs of one axis round otherwise, and the controller answers: what an encoder rounds away is
    noise. A simulation with counts holds noise of its own, which any small change shuffles. The
    parameter that sets the counts of the position is the one to which they are proportional, or
    inversely. One of an encoder that nobody sees is told by a shuffle that ends with finer counts.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    """
    if case.simulations.tracking is not None:
        return None
    found = _of_position(case)
    values, count = ({}, 0.0) if found is None else (dict(found.values), found.count)
    for _ in range(_MOST):
        hidden = hidden_counts(case, values)
        if not hidden:
            break
        values |= hidden
    return EncoderCounts(values, count) if values else None


def _of_position(case: Case) -> EncoderCounts | None:
    signal = case.rig.position
    if signal is None:
        return None
    columns = [run.response.held[signal] for run in case.nominal]
    most = int(np.argmax([np.unique(column).size for column in columns]))
    quantum = resolution(columns[most])
    if quantum == 0.0:
        return None
    for one in changeable(case.twin, (), also_certain=True):
        changed = case.simulations.run_one(Point({one.name: one.nominal * SMALL_CHANGE}), most)
        after = resolution(changed.response.held[signal]) if changed.finite else 0.0
        power = 0.0 if after == 0.0 else float(np.log(after / quantum) / np.log(SMALL_CHANGE))
        if abs(abs(power) - 1.0) > _UNLIKE:
            continue
        value = times(case.twin, one, FINER ** -round(power))
        runs = case.simulations.run([Point({one.name: value})])[0]
        if not all(run.finite for run in runs):
            continue
        fine = [run.response.held[signal] for run in runs]
        # It is the axis that it was, but for the counts.
        moved = [float(np.sqrt(np.mean((a - b) ** 2))) for a, b in zip(fine, columns, strict=True)]
        if resolution(fine[most]) * ENOUGH < quantum and max(moved) < quantum:
            return EncoderCounts({one.name: value}, quantum)
    return None
