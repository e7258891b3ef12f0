"""Runs on one even clock: gains, reference, measurement and command as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.history.state import TuningState

MOST_ROWS = 4000
"""Most samples of a run that are simulated; a longer one is taken at a lower rate."""


@dataclass(frozen=True, eq=False)
class SampledRuns:
    """R runs at the same n instants.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s] Evenly spaced.
    gains : ndarray, shape (R, d)
        As shares of the largest value of each gain.
    reference, measured, command : ndarray, shape (R, n)
        [unit of the signal] A run holds the command that is in force just before each instant.
    """

    time: NDArray[np.float64]
    gains: NDArray[np.float64]
    reference: NDArray[np.float64]
    measured: NDArray[np.float64]
    command: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.gains)

    @property
    def step(self) -> float:
        """[s] Between two samples."""
        return float(self.time[1] - self.time[0])

    @classmethod
    def of(cls, trials: Sequence[Trial], state: TuningState) -> Self | None:
        """Runs that ended well; None without any, or where a command was not recorded.

        Parameters
        ----------
        trials : sequence of Trial
            Of any source.
        state : TuningState
            Names the signals, and holds the clock of the reference.
        """
        signal, command = state.experiment.signal, state.experiment.terms.command
        good = [
            trial
            for trial in trials
            if trial.status == "ok"
            and command in trial.recording.signals
            and signal in trial.recording.signals
        ]
        if not good or command is None or len(state.experiment.parts) != 1:
            return None
        part = state.experiment.parts[0]
        clock = good[0].recording.time
        stride = -(-len(clock) // MOST_ROWS)
        time = np.linspace(clock[0], clock[-1], (len(clock) - 1) // stride + 1)
        most = np.maximum(np.abs(state.space.bounds).max(axis=0), np.finfo(float).tiny)
        points = [[trial.gains[name] for name in state.space.names] for trial in good]

        def on_clock(name: str) -> NDArray[np.float64]:
            return np.stack([_at(trial, name, time) for trial in good])

        return cls(
            time=time,
            gains=np.array(points) / most,
            reference=np.tile(part.target(time), (len(good), 1)),
            measured=on_clock(signal),
            command=on_clock(command),
        )

    def only(self, rows: NDArray[np.int_] | slice) -> SampledRuns:
        """Some of the runs.

        Parameters
        ----------
        rows : ndarray of int or slice
            Which.
        """
        return SampledRuns(
            self.time,
            self.gains[rows],
            self.reference[rows],
            self.measured[rows],
            self.command[rows],
        )


def _at(trial: Trial, name: str, time: NDArray[np.float64]) -> NDArray[np.float64]:
    recording = trial.recording
    values = recording.signal(name)
    known = ~np.isnan(values)
    return np.asarray(np.interp(time, recording.time[known], values[known]))
