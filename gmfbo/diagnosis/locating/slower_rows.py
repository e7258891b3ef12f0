"""Rows that are slower than the controller hide what it read between two of them.

A controller that computes every 1 ms, of a measurement that is known every 5 ms, cannot be
computed again: against the reference, each reading in between may have come up to half a row
sooner or later. Only what no such shift makes can be told.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.locating.held_twin import HeldTwin
from gmfbo.diagnosis.locating.parity import block_spread
from gmfbo.plain_words import duration
from gmfbo.sources.twin.response import Response

_SAME = 1.1  # ratio of two intervals below which clocks of two devices count as one

Column = NDArray[np.float64]


def computing_interval(base: Fitted, command: str, step: float) -> float:
    """[s] Usual time between two changes of the twin's own command, where it is shortest.

    Parameters
    ----------
    base : Fitted
        The twin's runs along the recordings.
    command : str
        Output that is the controller's command.
    step : float
        [s] Of the twin; a controller that computes more often is not seen.
    """
    changes = [np.flatnonzero(np.diff(run.response.held[command])) for run in base.simulated]
    # The median: at rest it changes rarely, and what is no whole number of steps changes by turns.
    usual = [np.diff(own) for own in changes if own.size > 1]
    near = [float(own[own <= np.median(own) + 1.0].mean()) for own in usual]
    return step * min(near, default=1.0)


def row_interval(case: Case, position: str) -> float:
    """[s] Mean time between two rows of the measured position, in the slowest recording.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    position : str
        Output that was recorded as the position.
    """
    spacings = []
    for record in case.simulations.records:
        recording = record.plan.recording
        time = recording.time[np.isfinite(recording.signal(position))]
        spacings.append(float(time[-1] - time[0]) / max(1, time.size - 1))
    return max(spacings)


def are_slower(rows: float, controller: float) -> bool:
    """Whether rows come more slowly than the controller computes.

    Parameters
    ----------
    rows, controller : float
        [s] Intervals.
    """
    return rows > _SAME * controller


def as_logged(computed: Column, grid: Column, rows: Column) -> Column:
    """Take a computed command at the rows alone, and go straight from row to row as between them.

    A command that is held for several steps of the twin is known at its rows, and not where the
    straight line between two of them lies.

    Parameters
    ----------
    computed : ndarray, shape (n_steps,)
        Command of the twin's controller, at each step.
    grid : ndarray, shape (n_steps,)
        [s] Those steps.
    rows : ndarray, shape (n_rows,)
        [s] At which the command was recorded.
    """
    return np.asarray(np.interp(grid, rows, np.interp(rows, grid, computed)), dtype=np.float64)


def hidden_by_rows(twin: HeldTwin, command: str, held: Sequence[Response], rows: float) -> float:
    """[SI unit of the command] What it changes by where readings come at other times.

    They come half a row later, and at the times that the rows beside them tell: a clock that is
    rounded makes a speed of its own between two rows.

    Parameters
    ----------
    twin : HeldTwin
        Its controller reads the recorded measurement.
    command : str
        Output that is the controller's command.
    held : sequence of Response
        The twin on the readings as they were recorded.
    rows : float
        [s] Between two readings.

    Returns
    -------
    float
        Spread of the means of blocks; infinite where the twin cannot be held on such readings.
    """
    grids = [record.plan.grid for record in twin.case.simulations.records]
    later = {k: np.interp(g - 0.5 * rows, g, twin.recorded(k)) for k, g in enumerate(grids)}
    evened = {k: _evened(twin, k) for k in later}
    return math.hypot(*(_changed(twin, command, held, one) for one in (later, evened)))


def _evened(twin: HeldTwin, k: int) -> Column:
    """Readings at the mean of their own time and of that halfway between their neighbours."""
    plan = twin.case.simulations.records[k].plan
    time = plan.recording.time[np.isfinite(plan.recording.signal(twin.position))]
    even = time.copy()
    even[1:-1] += 0.25 * np.diff(time, 2)
    shifted = plan.grid + np.interp(plan.grid, even, time - even)
    return np.asarray(np.interp(shifted, plan.grid, twin.recorded(k)), dtype=np.float64)


def _changed(
    twin: HeldTwin, command: str, held: Sequence[Response], readings: Mapping[int, Column]
) -> float:
    records = twin.case.simulations.records
    runs = twin.run(readings)
    if runs is None:
        return math.inf
    moved = []
    for record, before, after in zip(records, held, runs, strict=True):
        grid = record.plan.grid
        inside = (grid >= record.start - 1e-9) & (grid <= record.end + 1e-9)
        change = np.asarray(after.held[command] - before.held[command], dtype=np.float64)
        moved.append(np.where(inside, change, np.nan))
    return block_spread([record.plan.grid for record in records], moved)


def why_slower(rows: float, controller: float) -> str:
    """Say that rows are slower than the controller, and what to do, in one line.

    Parameters
    ----------
    rows, controller : float
        [s] Intervals.
    """
    return (
        f"rows are slower than the controller ({duration(rows)}, while it computes every "
        f"{duration(controller)}); to have it checked, log a row each time that it computes"
    )
