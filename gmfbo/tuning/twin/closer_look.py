"""Closer look: runs of the twin around promising gains, denser than the survey of the box.

Gains that are good enough may fill less than a thousandth of the box, as a ridge between overshoot
and creep, while a survey of 400 runs leaves gaps of a fortieth of each range.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from gmfbo.space import folded
from gmfbo.tuning.history.history import History
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.query.initial_design import Stream, stream
from gmfbo.tuning.query.method import Method
from gmfbo.tuning.twin.points_around import points_around
from gmfbo.tuning.twin.twin_runs import TwinRuns

RADII = (0.03, 0.01)
"""Standard deviations of the draws of a stage, over the unit cube: about a survey's spacing, and
about the width of a ridge."""


@runtime_checkable
class LookingMethod(Protocol):
    """A method that chooses among gains at which the twin was run."""

    def promising(self, state: TuningState) -> NDArray[np.float64]:
        """Promising points of the unit cube, shape (c, d), best first."""
        ...


def look_closer(method: Method, runs: TwinRuns) -> None:
    """Run the twin around the promising gains, stage by stage; after a kill, make the rest.

    The runs belong to the last real run; the next real run causes new ones.

    Parameters
    ----------
    method : Method
        Its `correction.closer` is the number of runs in a stage for each gain.
    runs : TwinRuns
        Runs of the present twin.
    """
    options, history = runs.correction, runs.history
    real = history.of("IS1")
    if options is None or not options.closer or not isinstance(method, LookingMethod):
        return
    if len(real) < max(history.study.budget.initial_is1, 1):
        return
    seed, count = history.study.seed, options.closer * len(history.gains.space)
    beside = 1  # the first twin run of a real run is made at its gains
    if not options.corrected:
        beside += len(points_around(history, real[-1]))
    for stage, radius in enumerate(RADII):
        known = beside + stage * count
        made = len(history.children(real[-1], "IS2"))
        if made >= known + count:
            continue
        if history.twin_used_up:
            return
        centres = method.promising(_without(history, real[-1].number, known))
        if not len(centres):
            return
        rng = stream(seed, Stream.CLOSER_LOOK, real[-1].number, stage)
        draws = rng.normal(0.0, radius, (count, len(history.gains.space)))
        points = folded(centres[np.arange(count) % len(centres)] + draws)
        for point in points[made - known :]:
            runs.beside_again(real[-1], history.gains_at(point))


def _without(history: History, real: int, known: int) -> TuningState:
    """The state with only the first twin runs that belong to the last real run."""
    state = history.state({})
    own = [t.number for t in state.trials if t.source == "IS2" and t.parent == real][known:]
    return replace(
        state,
        trials=tuple(trial for trial in state.trials if trial.number not in own),
        observations=tuple(seen for seen in state.observations if seen.number not in own),
    )
