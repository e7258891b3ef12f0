"""The twin's own encoder counts, and the value of its parameter that leaves none."""

from __future__ import annotations

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.problem import EncoderCounts
from gmfbo.diagnosis.comparison.starting.fixed_parameters import SMALL_CHANGE, changeable
from gmfbo.diagnosis.runs.quantum import resolution
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.uncertain import Uncertain

_UNLIKE = 0.1  # by which the power of the parameter in a count may differ from 1 or -1
_FINER, _FEWEST = 1000.0, 10.0  # counts in the place of one, and how many would do


def encoder_counts(case: Case) -> EncoderCounts | None:
    """How to simulate the twin without the counts of its encoder; None where that is not known.

    Two runs of one axis round otherwise, and the controller answers: what an encoder rounds away is
    noise. A simulation with counts holds noise of its own, which any small change shuffles. The
    parameter that sets the counts is the one to which they are proportional, or inversely.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    """
    signal = case.rig.position
    if signal is None or case.simulations.tracking is not None:
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
        value = _finest(case.twin, one, power)
        runs = case.simulations.run([Point({one.name: value})])[0]
        if not all(run.finite for run in runs):
            continue
        fine = [run.response.held[signal] for run in runs]
        # It is the axis that it was, but for the counts.
        moved = [float(np.sqrt(np.mean((a - b) ** 2))) for a, b in zip(fine, columns, strict=True)]
        if resolution(fine[most]) * _FEWEST < quantum and max(moved) < quantum:
            return EncoderCounts(one.name, value, quantum)
    return None


def _finest(twin: FmuTwin, one: Uncertain, power: float) -> float:
    """Value with a thousand times the counts, or as many as the FMU allows."""
    value = one.nominal * _FINER ** -round(power)
    variable = twin.binding.parameters[one.name].variable
    if variable.minimum is not None:
        value = max(value, variable.minimum)
    return value if variable.maximum is None else min(value, variable.maximum)
