"""What a recorded input may have done between its rows, where a straight line stands for it.

A current in peaks as short as two rows turns a motor by an amount that its rows do not tell. A
stationary disturbance of the command would be as large at rest as in the peaks.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.sources.binding.augmented_binding import command_input
from gmfbo.sources.twin.signals import to_fmu

Array = NDArray[np.float64]

_MOST = 200
"""Rows of a recording, those of the largest changes: the rest is left to the command's disturbance.

A whitening decomposes one column a row.
"""


def error_over_rows(values: Array) -> Array:
    """Standard deviation of a path's mean from each row to the next, about a straight line.

    A twelfth of the squared change is the variance of this mean for a step at any instant between
    the two rows (uniform distribution), and as well for a path of independent increments that
    change by as much (Brownian bridge).

    Parameters
    ----------
    values : ndarray, shape (n,)
        Of the rows.

    Returns
    -------
    ndarray, shape (n - 1,)
        In their unit.
    """
    deviation: Array = np.abs(np.diff(values)) / np.sqrt(12.0)
    return deviation


def unseen_input(record: Record, kernels: PortKernels) -> tuple[Array, ...] | None:
    """Signals that this error makes in each row of an input, each of one standard deviation.

    Parameters
    ----------
    record : Record
        A recording.
    kernels : PortKernels
        Paths of noise in it.

    Returns
    -------
    tuple of ndarray, shape (k, n), or None
        [SI] By signal at its own times; None unless the command is an input that goes straight
        from row to row. One that is held is what a controller made at each row.
    """
    plan, paths = record.plan, kernels.simulated.get("command")
    file, name = plan.experiment.binding.file, command_input(plan.experiment.binding)
    if paths is None or name is None or name not in plan.experiment.inputs:
        return None
    entry = file.inputs[name]
    column = plan.recording.signal(name)
    known = np.isfinite(column)
    if entry.interpolation != "linear" or np.count_nonzero(known) < 2:
        return None
    variable = plan.experiment.binding.variables[entry.variable].variable
    time, values = plan.recording.time[known], to_fmu(variable, column[known])
    sizes = error_over_rows(values)
    rows = np.sort(np.argsort(-sizes, kind="stable")[:_MOST])
    rows = rows[sizes[rows] > 0.0]
    begun, over, sizes = time[rows], time[rows + 1], sizes[rows]
    return tuple(
        _held(paths[signal.name], kernels.step, signal.time, begun, over) * sizes[:, None]
        for signal in record.signals
    )


def _held(path: Array, step: float, time: Array, begun: Array, over: Array) -> Array:
    """Answer to a unit push from each of some times to others, shape (k, n) [s]."""
    after = step * np.arange(path.size)
    whole = np.cumsum(path)  # of a push that stays
    found = [
        np.interp(time - a, after, whole, left=0.0) - np.interp(time - b, after, whole, left=0.0)
        for a, b in zip(begun, over, strict=True)
    ]
    return np.array(found).reshape(begun.size, time.size)
