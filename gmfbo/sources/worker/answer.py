"""Read a worker's answers defensively, since foreign code runs in its process."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from gmfbo.sources.fmu_file.job import Outcome, Stage, Status
from gmfbo.sources.worker.post_mortem import plain_line


def read_outcomes(
    answer: Mapping[str, Any], outputs: Sequence[NDArray[np.float64]]
) -> list[Outcome] | None:
    """Outcome of each run from the worker's answer; None where the answer is invalid.

    Parameters
    ----------
    answer : mapping
        From JSON.
    outputs : sequence of ndarray, shape (rows, n)
        One array for each run asked for.
    """
    outcomes = []
    try:
        for raw, y in zip(answer["outcomes"], outputs, strict=False):
            outcome = Outcome(**raw)
            numbers = (outcome.rows, outcome.warnings, outcome.stage)
            if not all(isinstance(number, int) for number in numbers):
                return None
            if outcome.status not in get_args(Status) or not 0 <= outcome.rows <= len(y):
                return None
            if outcome.status == "ok" and outcome.rows != len(y):
                return None
            line = plain_line(outcome.message)
            outcomes.append(replace(outcome, message=line, stage=Stage(outcome.stage)))
    except (KeyError, TypeError, ValueError):
        return None
    return outcomes or None


def filled_rows(y: NDArray[np.float64]) -> int:
    """Leading rows without NaN: outputs are NaN until they are written.

    Parameters
    ----------
    y : ndarray, shape (rows, n)
        Outputs of a run that was cut short.
    """
    blank = np.isnan(y).any(axis=1)
    return int(np.argmax(blank)) if blank.any() else len(y)
