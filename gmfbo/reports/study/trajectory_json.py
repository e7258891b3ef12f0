"""Trajectories of a study for the script of its page, thinned so that no peak is lost."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.pages.html_page import embedded_json
from gmfbo.pages.thinning import few_digits, thinned_rows
from gmfbo.recordings.store.trial import Trial
from gmfbo.reports.study.review import StudyReview

Array = NDArray[np.float64]

_MOST_NUMBERS = 280_000
"""Of all simulated runs, half of them for the most viewed ones: about two megabytes."""

_FEWEST_ROWS = 40  # of a simulated run
_REAL_ROWS = 1600  # of a real run: a lowest and a highest point for each pixel of the chart
_DIGITS = 5


def _shown_signals(review: StudyReview) -> dict[str, str]:
    """Signals of the real runs that a page shows, with their units; that of the cost first."""
    # A row of a table has no signals.
    real = [run for run in review.real if not run.trial.bare] or review.runs
    first = real[0].trial.recording
    scored, reference = review.file.objective.signal, review.file.reference.signal
    names = [scored, *(n for n in first.signals if n not in (scored, reference))]
    return {name: first.units.get(name, "") for name in names[:4] if name in first.signals}


def trajectories_json(review: StudyReview) -> str:
    """Embed the trajectory of every run into the page.

    Returns
    -------
    str
        A `<script>` element. `runs` holds by number and signal the times `t` [s] and values `y`;
        for a corrected run also the values before correction, `u`, and the standard deviation,
        `s`.
    """
    signals = _shown_signals(review)
    scored = [name for name in signals if name == review.file.objective.signal]
    real = [run.trial for run in review.real]
    simulated = [run.trial for run in review.runs if run.trial.source != "IS1"]
    often = [trial for trial in simulated if trial.parent is not None]
    seldom = [trial for trial in simulated if trial.parent is None]
    names = list(signals)
    groups = (
        (real, names, _REAL_ROWS),
        (often, names, _rows_each(often, names)),
        (seldom, scored, _rows_each(seldom, scored)),
    )
    told = {
        "signals": [{"name": name, "unit": unit} for name, unit in signals.items()],
        "reference": _reference(review),
        "runs": {
            str(trial.number): _run(trial, shown, most)
            for trials, shown, most in groups
            for trial in trials
        },
    }
    return embedded_json("trajectories", json.dumps(told, separators=(",", ":"), allow_nan=False))


def _rows_each(trials: Sequence[Trial], names: Sequence[str]) -> int:
    """Most rows of each trial, for times and values of each signal."""
    numbers = 2 * max(len(names), 1) * max(len(trials), 1)
    return max(_MOST_NUMBERS // (2 * numbers), _FEWEST_ROWS)


def _run(trial: Trial, signals: Sequence[str], most: int) -> dict[str, Any]:
    time, told = trial.recording.time, {}
    for name in signals:
        if name not in trial.recording.signals:
            continue
        values = trial.recording.signal(name)
        extra = {
            key: held[name]
            for key, held in (("u", trial.uncorrected), ("s", trial.std))
            if name in held
        }
        rows = thinned_rows([values], most // 2)
        told[name] = {
            "t": few_digits(time[rows], 7),
            "y": few_digits(values[rows], _DIGITS),
            **{key: few_digits(column[rows], _DIGITS) for key, column in extra.items()},
        }
    return told


def _reference(review: StudyReview) -> dict[str, Any] | None:
    """Reference of the axis, from the first run that recorded it."""
    name = review.file.reference.signal
    for run in (*review.real, *review.runs):
        recording = run.trial.recording
        if name in recording.signals:
            rows = thinned_rows([recording.signal(name)], 200)
            values = recording.signal(name)[rows]
            return {"t": few_digits(recording.time[rows], 7), "y": few_digits(values, _DIGITS)}
    return None
