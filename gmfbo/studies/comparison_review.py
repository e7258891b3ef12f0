"""Read a comparison's folder for its page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gmfbo.reports.comparison.curves import ComparisonReview, MethodSummary, SeedRun
from gmfbo.studies.bootstrap import Interval
from gmfbo.studies.comparison import Comparison
from gmfbo.studies.comparison_folder import ComparisonFolder, by_method
from gmfbo.studies.curves import read_curves
from gmfbo.studies.landscape import read_landscape
from gmfbo.studies.outcome import Outcome


def review_comparison(folder: str | Path) -> ComparisonReview:
    """Read a comparison; if its runs are missing, only its tables and curves.

    Parameters
    ----------
    folder : str or Path
        Folder written by `compare`.

    Raises
    ------
    StoreError
        There are no tables, or one of them is damaged.
    """
    kept = ComparisonFolder(Path(folder))
    text = Comparison.read(kept.path).text
    outcomes = by_method(kept.finished_runs)
    return ComparisonReview(
        name=kept.path.resolve().name.removesuffix(".compare"),
        text=text,
        curves=tuple(read_curves(kept.curves)),
        landscape=read_landscape(kept.landscape),
        runs=tuple(_run(one) for column in outcomes.values() for one in column),
        methods=tuple(_summary(column) for column in outcomes.values()),
    )


def _run(outcome: Outcome) -> SeedRun:
    return SeedRun(
        method=outcome.method,
        seed=outcome.seed,
        n_star=outcome.n_star,
        never=outcome.never,
        best=np.array(outcome.best),
        regret=np.array(outcome.regret),
        cost=outcome.cost[-1],
        twin_runs=outcome.twin_runs,
        corrected_runs=outcome.corrected_runs,
        seconds=outcome.seconds_before + sum(outcome.seconds),
    )


def _summary(outcomes: Sequence[Outcome]) -> MethodSummary:
    runs = [_run(one) for one in outcomes]
    counted = [float(run.counted) for run in runs]
    return MethodSummary(
        method=runs[0].method,
        seeds=len(runs),
        median=Interval.of(counted, np.median),
        mean=Interval.of(counted, np.mean),
        never=float(np.mean([run.n_star is None for run in runs])),
        regret=float(np.mean([run.regret[-1] for run in runs])),
        cost=float(np.mean([run.cost for run in runs])),
        seconds=float(np.mean([run.seconds for run in runs])),
    )
