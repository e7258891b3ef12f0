"""One recorded command beside the one that the twin's controller computes of the measurement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.locating.controller_memory import ControllerMemory, beside_memory
from gmfbo.diagnosis.locating.parity import block_means
from gmfbo.diagnosis.locating.slower_rows import as_logged
from gmfbo.diagnosis.runs.scored_record import ScoredSignal
from gmfbo.sources.twin.response import Response

Array = NDArray[np.float64]

_CONSTANT = 0.9  # least share of what a memory explains, where that is a constant


@dataclass(frozen=True, eq=False)
class ComparedCommand:
    """A recorded command, and what of it counts.

    Attributes
    ----------
    case : Case
        At nominal parameters.
    record : int
        Index of the recording.
    command : str
        Output that is the controller's command.
    which : str
        Whether a row stores the `held` or the `new` command.
    memory : ControllerMemory
        What the controller may have held before the recording.
    """

    case: Case
    record: int
    command: str
    which: str
    memory: ControllerMemory

    @property
    def grid(self) -> Array:
        """[s] Communication points, shape (n_steps,)."""
        return self.case.simulations.records[self.record].plan.grid

    def computed(self, run: Response) -> Array:
        """Command of the twin's controller as the logger would have stored it."""
        column = (run.new if self.which == "new" else run.held)[self.command]
        return as_logged(column, self.grid, self._signal().time)

    def recorded(self) -> Array:
        """[SI] Recorded command on the communication grid."""
        signal = self._signal()
        return np.asarray(np.interp(self.grid, signal.time, signal.values), dtype=np.float64)

    def means(self, column: Array) -> Array:
        """Means of blocks of a column, without what the controller's memory explains."""
        return beside_memory(self._blocks(column), self._memory())

    def residual(self, expected: Array) -> Array:
        """Means of blocks of recorded less computed command, without the memory's part."""
        return self.means(self.recorded() - expected)

    def share_left(self, run: Response) -> float:
        """Power of the difference at the rows over that of the command, without the memory's."""
        signal = self._signal()
        rows, grid = signal.time, self.grid
        changes = self.memory.answers[self.which].T
        answers = np.array([np.interp(rows, grid, own) for own in changes]).reshape(-1, rows.size)
        difference = np.where(
            self.memory.tells(rows),
            signal.values - np.interp(rows, grid, self.computed(run)),
            np.nan,
        )
        left = beside_memory(difference, answers.T)
        return float(np.nanmean(left**2)) / (float(np.var(signal.values)) or 1.0)

    @property
    def row(self) -> float:
        """[s] Between two rows of the command."""
        return self._signal().spacing

    def shift_left(self, expected: Array) -> float:
        """[s] Small delay of the recorded command that explains most of the difference."""
        rate = self.means(np.gradient(expected, self.grid))
        power = float(rate @ rate)
        return -float(rate @ self.residual(expected)) / power if power else 0.0

    def held_throughout(self, expected: Array, least: float) -> float:
        """Constant [SI] by which the memory may have changed the command; 0 where it is less.

        Parameters
        ----------
        expected : ndarray, shape (n_steps,)
            [SI] Computed command.
        least : float
            [SI] Root mean square of the difference that is noise.
        """
        difference = self._blocks(self.recorded() - expected)
        part = difference - beside_memory(difference, self._memory())
        power, mean = float(np.mean(part**2)), float(np.mean(part))
        is_seen = float(np.mean(difference**2)) > least**2
        return mean if is_seen and mean**2 > _CONSTANT * power else 0.0

    def _blocks(self, column: Array) -> Array:
        record, grid = self.case.simulations.records[self.record], self.grid
        inside = (grid >= record.start - 1e-9) & (grid <= record.end + 1e-9)
        return block_means(grid, np.where(inside & self.memory.tells(grid), column, np.nan))[1]

    def _memory(self) -> Array:
        count = self._blocks(self.grid).size
        answers = self.memory.answers[self.which].T
        return np.array([self._blocks(own) for own in answers]).reshape(-1, count).T

    def _signal(self) -> ScoredSignal:
        signals = self.case.simulations.records[self.record].signals
        return next(own for own in signals if own.name == self.command)
