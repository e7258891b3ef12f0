"""Errors of an open-loop twin over whole recordings, with nothing that corrects it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.fitted_starts import at_own_starts
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.result.explained import FreeRun
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.scoring.windows import starts_elsewhere


def free_runs(
    case: Case, scored: Sequence[int], plain: Fitted, augmented: Fitted | None
) -> dict[str, FreeRun]:
    """NRMSE of whole recordings by signal; none of a twin that its controller corrects.

    A recording that starts in another state than the twin tells nothing of it.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    scored : sequence of int
        Held-out windows: recordings that hold one of them count.
    plain : Fitted
        The twin with its uncertain parameters refitted.
    augmented : Fitted or None
        With named physics and freed parameters too; None where there are none.
    """
    simulations = case.simulations
    if simulations.tracking is None:
        return {}
    loop_time = case.setting.excitation.loop_time
    records = [
        k
        for k in sorted({case.budget.windows[i].record for i in scored})
        if not starts_elsewhere(
            simulations.records[k], case.nominal[k], case.rig.positions, loop_time
        )
    ]
    if not records:
        return {}
    models = [plain] if augmented is None else [plain, augmented]
    told_by = set(range(len(case.budget.windows))) - set(scored)
    own = [at_own_starts(case, model.hypothesis.point(model.x), told_by) for model in models]
    points = [Point(), *own]
    runs = [{k: simulations.run_freely(point, k) for k in records} for point in points]
    names = dict.fromkeys(s.name for k in records for s in simulations.records[k].signals)
    errors = {name: [*(_nrmse(case, name, run) for run in runs), float("nan")] for name in names}
    return {name: FreeRun(*found[:3]) for name, found in errors.items()}


def _nrmse(case: Case, name: str, runs: Mapping[int, Simulated]) -> float:
    """RMS error over the range of the recorded signal; NaN where a run ended early."""
    square, count, ends = 0.0, 0, [np.inf, -np.inf]
    for k, run in runs.items():
        signals = case.simulations.records[k].signals
        for signal, values in zip(signals, run.signals, strict=True):
            if signal.name == name:
                square += float(np.sum((signal.values - values) ** 2))
                count += signal.values.size
                ends = [
                    min(ends[0], float(signal.values.min())),
                    max(ends[1], float(signal.values.max())),
                ]
    extent = ends[1] - ends[0]
    return float(np.sqrt(square / count) / extent) if count and extent > 0.0 else float("nan")
