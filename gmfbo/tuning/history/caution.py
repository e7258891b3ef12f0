"""Where a real run may be made: away from unsafe gains, and not far from good ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.envelope import Envelope
from gmfbo.recordings.store.trial import Trial
from gmfbo.space import GainSpace
from gmfbo.tuning.history.incumbent import has_settled
from gmfbo.tuning.history.keep_out import KeepOut
from gmfbo.tuning.history.move_limit import MoveLimit

AGREEING_RUNS = 3
"""Real runs that agree with their prediction after which gains may move freely."""

AGREE_WITHIN = 2.0
"""Standard deviations of a prediction within which a run agrees with it."""


@dataclass(eq=False)
class Caution:
    """Caution of one study.

    Attributes
    ----------
    space : GainSpace
        Box of the tuned gains.
    envelope : Envelope
        Safety envelope.
    starts : ndarray, shape (k, d)
        Gains in force and other known-safe ones, in the unit cube.
    limited : bool
        Whether a gain moves by steps until the predictions have proved themselves.
    expected : dict of int to (float, float)
        Predicted cost of a real run and its standard deviation, by trial number.
    """

    space: GainSpace
    envelope: Envelope
    starts: NDArray[np.float64]
    limited: bool = False
    expected: dict[int, tuple[float, float]] = field(default_factory=dict)
    _leaves: dict[int, bool] = field(default_factory=dict)

    def keep_out(self, real: Sequence[Trial], twin: Sequence[Trial]) -> KeepOut:
        """Gains that a real run is kept away from.

        Parameters
        ----------
        real : sequence of Trial
            Real runs.
        twin : sequence of Trial
            Runs of the present twin, corrected ones included.
        """
        moves = self.moves(real)
        if not self.envelope:
            return KeepOut(moves=moves)
        # A run that broke down shows neither safety nor danger.
        inside = [trial for trial in real if trial.status == "ok" and not trial.bare]
        safe = [self._point(trial.gains) for trial in inside]
        unsafe = [self._point(trial.gains) for trial in real if trial.status == "unsafe"]
        unsafe += [self._point(trial.gains) for trial in twin if self._twin_leaves(trial)]
        width = len(self.space)
        return KeepOut(np.reshape(unsafe, (-1, width)), np.reshape(safe, (-1, width)), moves)

    def moves(self, real: Sequence[Trial]) -> MoveLimit | None:
        """Boxes in which the next real run lies; None where it may lie anywhere.

        A run moves away from the nearest gains that settled, or from those in force.

        Parameters
        ----------
        real : sequence of Trial
            Real runs.
        """
        if not self.limited or sum(map(self._agrees, real)) >= AGREEING_RUNS:
            return None
        good = [self._point(trial.gains) for trial in real if has_settled(trial)]
        return MoveLimit.around(self.space, np.vstack([self.starts, *good]))

    def _agrees(self, trial: Trial) -> bool:
        if trial.number not in self.expected or not has_settled(trial):
            return False
        mean, std = self.expected[trial.number]
        return abs(trial.objective - mean) <= AGREE_WITHIN * std

    def _twin_leaves(self, trial: Trial) -> bool:
        """Whether the twin left the envelope, as far as it computes the signals."""
        if trial.number not in self._leaves:
            left = self.envelope.first_exit(trial.recording, all_signals=False)
            self._leaves[trial.number] = left is not None
        return self._leaves[trial.number]

    def _point(self, gains: Mapping[str, float]) -> NDArray[np.float64]:
        return self.space.to_unit(self.space.point({n: gains[n] for n in self.space.names}))
