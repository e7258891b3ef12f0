"""Draw a real run over time, with the twin's run at its gains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gmfbo.errors import InputError
from gmfbo.plain_words import words
from gmfbo.recordings.store.trial import Trial
from gmfbo.reports.figures.figure_style import (
    GREEN,
    GREY,
    VERMILION,
    axis_label,
    in_style,
    new_figure,
)
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.run_marks import SOURCES
from gmfbo.tuning.history.incumbent import best_run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@in_style
def trajectories(
    review: StudyReview, number: int | None = None, signal: str | None = None
) -> Figure:
    """Draw a real run with the twin at the same gains and the corrected twin around it.

    Parameters
    ----------
    review : StudyReview
        The study as it is shown.
    number : int, optional
        Trial number of the real run, or of a run that it caused; the best with signals unless
        given.
    signal : str, optional
        Signal to draw; the scored one unless given.

    Returns
    -------
    matplotlib.figure.Figure
        The signal above, the twin's error below; corrected runs with their 95 % band.

    Raises
    ------
    InputError
        There is no such run or signal; or matplotlib is missing.
    """
    real = _real_run(review, number)
    name = signal or review.file.objective.signal
    if real.bare:
        raise InputError(f"run {real.number} is a row of a table, without signals; name another")
    if name not in real.recording.signals:
        raise InputError(
            f"expected a signal of run {real.number}, got '{name}'; known are "
            f"{', '.join(real.recording.signals)}"
        )
    figure = new_figure(5.8, 4.6)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    _draw_above(above, review, real, name)
    _draw_below(below, review, real, name)
    above.set_ylabel(axis_label(words(name), review.signal_unit(name)), parse_math=False)
    below.set_ylabel(axis_label("real less twin", review.signal_unit(name)), parse_math=False)
    below.set_xlabel("time [s]")
    handles, labels = above.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    figure.legend(unique.values(), unique.keys(), loc="outside upper center", ncols=2,
                  frameon=False)  # fmt: skip
    return figure


def _draw_above(axes: Axes, review: StudyReview, real: Trial, name: str) -> None:
    time, reference = real.recording.time, review.file.reference.signal
    if reference in real.recording.signals and name == review.file.objective.signal:
        asked = real.recording.signal(reference)
        axes.plot(time, asked, color=GREY, linestyle=":", label="reference")
    label = f"{SOURCES['IS1']}, run {real.number}"
    measured = real.recording.signal(name)
    axes.plot(time, measured, color="black", alpha=0.5, linewidth=2.2, label=label)
    around = [
        run.trial
        for run in review.runs
        if run.trial.parent == real.number and run.role == "corrected"
    ]
    for trial in filter(None, [review.twin_beside(real), *around]):
        if name in trial.recording.signals:
            _draw_twin(axes, trial, name)


def _draw_below(axes: Axes, review: StudyReview, real: Trial, name: str) -> None:
    time, measured = real.recording.time, real.recording.signal(name)
    beside = review.twin_beside(real)
    if beside is not None and name in beside.recording.signals:
        twin = beside.recording
        left = measured - np.interp(time, twin.time, twin.signal(name))
        axes.plot(time, left, color=VERMILION, linestyle="--")


def _draw_twin(axes: Axes, trial: Trial, name: str) -> None:
    time, values = trial.recording.time, trial.recording.signal(name)
    if trial.source == "IS2":
        label = f"{SOURCES['IS2']}, run {trial.number}"
        axes.plot(time, values, color=VERMILION, linestyle="--", label=label)
        return
    axes.plot(time, values, color=GREEN, linewidth=0.8, label=f"{SOURCES['IS3']}, nearby gains")
    if name in trial.std:
        band = 1.96 * trial.std[name]
        axes.fill_between(time, values - band, values + band, color=GREEN, alpha=0.2, linewidth=0)


def _real_run(review: StudyReview, number: int | None) -> Trial:
    if number is None:
        # A row of a table has nothing to draw.
        best = best_run((r.trial for r in review.real if not r.trial.bare), review.limits)
        if best is None:
            raise InputError("expected a study with a real run that succeeded; name a run")
        return review.best if review.best and not review.best.bare else best
    asked = review.trials.get(number)
    real = review.trials.get(asked.parent) if asked and asked.parent else asked
    if real is None or real.source != "IS1":
        known = ", ".join(str(run.trial.number) for run in review.real)
        raise InputError(f"expected a real run or one that belongs to it, got {number}; real runs "
                         f"are {known}")  # fmt: skip
    return real
