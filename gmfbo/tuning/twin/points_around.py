"""Gains around a real run at which the twin is run too, as candidates of the next query."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.store.trial import Trial
from gmfbo.space import folded
from gmfbo.tuning.history.history import History
from gmfbo.tuning.query.initial_design import Stream, stream

SPREAD = 0.05
"""Standard deviation of the draws over the unit cube, as the publication states it."""


def points_around(history: History, real: Trial) -> NDArray[np.float64]:
    """Points around a real run, shape (c, d), in the unit cube; none where a run there failed.

    They follow from the seed and the real run alone, so that a killed study makes the same runs.

    Parameters
    ----------
    history : History
        With the twin's run beside the real one.
    real : Trial
        The real run.
    """
    beside = history.children(real, "IS2")
    count = history.study.budget.is3_per_run
    if real.status != "ok" or not beside or beside[0].status != "ok":
        count = 0
    rng = stream(history.study.seed, Stream.IS3, real.number)
    draws = rng.normal(0.0, SPREAD, (count, len(history.gains.space)))
    return folded(history.unit_point(real.gains) + draws)
