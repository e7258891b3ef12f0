"""Progress of a running study."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from gmfbo.recordings.store.trial import SourceName

Phase = Literal["initial", "query", "correction", "drift", "twin", "news", "done"]


@dataclass(frozen=True)
class Progress:
    """One finished run within a study.

    Attributes
    ----------
    phase : {"initial", "query", "correction", "drift", "twin", "news", "done"}
        Initial data, a query, twin runs after a real run, a detected change of the plant, a
        correction of the twin, a sentence for the user without a run, or the end of the study.
    iteration, iterations : int
        Number of queries made, and their limit.
    is1_runs : int
        Number of real runs so far, initial ones included.
    trial : int
        Number of the run.
    source : {"IS1", "IS2", "IS3"}
        Source of the run.
    gains : mapping of str to float
        Gains of the run.
    objective : float
        Its cost g.
    status : str
        `ok`, or how the run ended early.
    best_objective : float or None
        Least cost of a real run so far.
    best_gains : mapping of str to float or None
        Its gains.
    mismatch : float or None
        Newest mismatch e of the twin, dimensionless; None for methods without one.
    cost : float
        Cost of all runs so far, in units of a real run.
    seconds : float
        [s] Time since this call of `run` began.
    seconds_left : float or None
        [s] Expected time until the end; None before the first query.
    note : str
        Note of the method, such as a fit that fell back; usually empty.
    initial_runs, most_initial_runs : int
        Number of initial runs of both sources so far, and in all.
    """

    phase: Phase
    iteration: int
    iterations: int
    is1_runs: int
    trial: int
    source: SourceName
    gains: Mapping[str, float]
    objective: float
    status: str
    best_objective: float | None
    best_gains: Mapping[str, float] | None
    mismatch: float | None
    cost: float
    seconds: float
    seconds_left: float | None
    note: str = ""
    initial_runs: int = 0
    most_initial_runs: int = 0


ProgressCallback = Callable[[Progress], None]
