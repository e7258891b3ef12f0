"""Runs of a study as tables: real runs shown, all runs folded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from gmfbo.pages.html_page import folded, table
from gmfbo.pages.marked_number import marked_count, marked_number
from gmfbo.recordings.store.trial import Trial
from gmfbo.reports.study.metric_cells import metric_cell, metric_head
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.run_roles import ROLES, Run
from gmfbo.tuning.history.incumbent import has_settled


def runs_tables(review: StudyReview) -> str:
    """Write the tables.

    Returns
    -------
    str
        HTML; the number of each run is a button that shows it where the page's script runs.
    """
    places = {run.trial.number: place for place, run in enumerate(review.runs)}
    real = _table(review, review.real, places)
    real += _taken_back(review)
    if len(review.real) == len(review.runs):
        return real
    everything = _table(review, review.runs, places)
    return real + f'<div class="on-screen">{folded("All runs of all sources", everything)}</div>'


def _taken_back(review: StudyReview) -> str:
    """Real runs that were taken back, struck out."""
    lines = []
    for trial in review.taken_back:
        if trial.source == "IS1":
            gains = ", ".join(f"{name} = {value:.4g}" for name, value in trial.gains.items())
            told = f"run {trial.number}: {gains}, objective {trial.objective:.4g}"
            lines.append(f"<li><s>{escape(told)}</s></li>")
    if not lines:
        return ""
    return (
        "<p>Taken back after they were told; on disk, but counted no more:</p>"
        f"<ul>{''.join(lines)}</ul>"
    )


def _table(review: StudyReview, runs: Sequence[Run], places: dict[int, int]) -> str:
    heads = [
        "run",
        "source",
        "what for",
        "query",
        *review.space.names,
        "objective",
        *(metric_head(review, name) for name in review.metrics),
        "ended",
        "cost so far",
    ]
    rows = [_row(review, run, ("runs", places[run.trial.number])) for run in runs]
    best = next((k for k, run in enumerate(runs) if run.trial is review.best), None)
    ended = heads.index("ended")
    numbers = [*range(heads.index("query"), ended), ended + 1]
    return table(heads, rows, numbers=numbers, style="wide runs", best=best)


def _ended(trial: Trial) -> str:
    """How a run ended: a status of `ok` alone does not say whether it settled."""
    return "not settled" if trial.status == "ok" and not has_settled(trial) else trial.status


def _row(review: StudyReview, run: Run, path: tuple[str, int]) -> list[str]:
    trial = run.trial
    number = marked_count((*path, "number"), trial.number)
    return [
        f'<button type="button" data-run="{trial.number}">{number}</button>',
        trial.source,
        escape(ROLES[run.role]),
        marked_count((*path, "query"), run.query),
        *(
            marked_number((*path, "gains", name), trial.gains[name], digits=4)
            for name in review.space.names
        ),
        marked_number((*path, "objective"), trial.objective, digits=4),
        *(
            metric_cell(review, name, (*path, "metrics", name), trial.metrics.get(name, math.nan))
            for name in review.metrics
        ),
        escape(_ended(trial)),
        marked_number((*path, "cost"), run.cost, digits=4),
    ]
