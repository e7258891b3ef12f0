"""What a controller held before its recording began, as far as its command shows it.

The twin's controller starts empty. A drive that was on before the first row had an integral, a
filter and earlier readings of its own, which nobody recorded. Short pulses of the first readings
leave such a memory in the twin's controller, one independent of the other. What they change of
its later command is all that an unknown memory can change (free response, Kailath 1980, 2.3).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.locating.held_twin import HeldTwin
from gmfbo.diagnosis.scoring.noise_levels import POSITION_TOLERANCE
from gmfbo.sources.twin.response import Response

_STATES = 4  # numbers that a controller keeps: integral, filter, and two earlier readings
_ROUND_OFF = 1e-9  # of the answer while the pulse lasts: less of it later is no memory
_LEAST_VALUES = 3  # for each number kept: of fewer, a memory would explain any fault
_SAME = 1e-4  # of the largest independent answer: less is the twin's round-off and leaks

Column = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ControllerMemory:
    """Changes of a command that only show what its controller held before the recording.

    Attributes
    ----------
    start : float
        [s] From which the command shows a memory and no longer the pulse that made it.
    answers : mapping of str to ndarray, shape (n_steps, n)
        Such changes of the `held` and of the `new` command, [1] each scaled to one; n is 0 where
        the controller keeps nothing.
    """

    start: float
    answers: Mapping[str, Column]

    def tells(self, grid: Column) -> NDArray[np.bool_]:
        """Whether a command at these times [s] is more than what a pulse made of it."""
        return np.asarray(grid >= self.start - 1e-9, dtype=np.bool_)


def beside_memory(values: Column, answers: Column) -> Column:
    """Part of values that no memory explains (least squares); NaN where values are.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Such as a command's residual.
    answers : ndarray, shape (n, n_answers)
        Of a memory, at the same times.
    """
    known = np.isfinite(values)
    size = np.sqrt(np.mean(answers[known] ** 2, axis=0)) if known.any() else np.zeros(0)
    own = answers[:, size > 0.0] / size[size > 0.0]
    if not size.any() or known.sum() < _LEAST_VALUES * own.shape[1]:
        return values
    shares = np.linalg.lstsq(own[known], values[known], rcond=_SAME)[0]
    return np.asarray(values - own @ shares, dtype=np.float64)


def controller_memories(
    twin: HeldTwin, command: str, held: Sequence[Response], interval: float
) -> tuple[ControllerMemory, ...]:
    """Find what a memory can change of each recording's command.

    Parameters
    ----------
    twin : HeldTwin
        Its controller reads the recorded measurement.
    command : str
        Output that is the controller's command.
    held : sequence of Response
        The twin on the readings as they were recorded.
    interval : float
        [s] Between two readings that the controller uses.
    """
    records = twin.case.simulations.records
    pulsed = [_pulsed(twin, place, interval) for place in range(_STATES)]
    runs = [own for own in map(twin.run, pulsed) if own is not None]
    found = []
    for k, record in enumerate(records):
        grid = record.plan.grid
        # A held command shows the last pulse for one more interval.
        start = float(grid[0]) + (_STATES + 1) * interval
        changes = {
            which: [
                getattr(own[k], which)[command] - getattr(held[k], which)[command] for own in runs
            ]
            for which in ("held", "new")
        }
        found.append(_memory(grid, start, changes))
    return tuple(found)


def _pulsed(twin: HeldTwin, place: int, interval: float) -> dict[int, Column]:
    """Measurements whose reading number `place` is off by as much as its noise."""
    changed = {}
    for k, record in enumerate(twin.case.simulations.records):
        since = record.plan.grid - record.plan.grid[0] + 1e-9
        during = (since >= place * interval) & (since < (place + 1) * interval)
        changed[k] = twin.recorded(k) + _level(twin, k) * during
    return changed


def _level(twin: HeldTwin, k: int) -> float:
    """[FMU's unit] Small beside the motion, so that no limit cuts the command's answer."""
    noise = twin.case.noise.get(twin.position)
    if noise is not None:
        return noise.total / twin.case.rig.position_to_si
    return POSITION_TOLERANCE * float(np.ptp(twin.recorded(k)))


def _memory(
    grid: Column, start: float, changes: Mapping[str, Sequence[Column]]
) -> ControllerMemory:
    later = grid >= start - 1e-9
    answers = {}
    for which, own in changes.items():
        peaks = [float(np.abs(change).max()) for change in own]
        kept = [
            change / peak
            for change, peak in zip(own, peaks, strict=True)
            if peak and np.abs(change[later]).max(initial=0.0) > _ROUND_OFF * peak
        ]
        answers[which] = np.column_stack(kept) if kept else np.zeros((grid.size, 0))
    keeps = any(own.shape[1] for own in answers.values())
    return ControllerMemory(start if keeps else float(grid[0]), answers)
