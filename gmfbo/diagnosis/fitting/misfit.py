"""Whitened differences between recordings and hypotheses, and their sensitivities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.whitening import Whitener

Blocks = tuple[NDArray[np.float64], ...]
"""Whitened values of each window, shape (..., n_residuals of that window)."""


@dataclass(frozen=True, eq=False)
class Misfit:
    """Recordings against the augmented twin, window by window.

    Attributes
    ----------
    simulations : Simulations
        Simulators of the twin.
    whiteners : tuple of Whitener
        One a window.
    """

    simulations: Simulations
    whiteners: tuple[Whitener, ...]

    def residual(self, simulated: Sequence[Simulated]) -> Blocks:
        """Recorded minus simulated, whitened."""
        records = self.simulations.records
        blocks = []
        for whitener in self.whiteners:
            k = whitener.window.record
            columns = [
                signal.values - run
                for signal, run in zip(records[k].signals, simulated[k].signals, strict=True)
            ]
            blocks.append(whitener.whiten(columns))
        return tuple(blocks)

    def change(self, after: Sequence[Simulated], before: Sequence[Simulated]) -> Blocks:
        """Whitened change of the simulated signals."""
        return self.whitened(
            [
                tuple(a - b for a, b in zip(x.signals, y.signals, strict=True))
                for x, y in zip(after, before, strict=True)
            ]
        )

    def whitened(self, columns: Sequence[Sequence[NDArray[np.float64]]]) -> Blocks:
        """Whiten columns of each recording's signals."""
        return tuple(w.whiten(columns[w.window.record]) for w in self.whiteners)

    def run_moved(
        self,
        hypothesis: Hypothesis,
        x: NDArray[np.float64],
        moves: NDArray[np.float64],
        *,
        parallel: bool,
    ) -> list[list[Simulated]]:
        """Simulate the recordings at x + move for each move, shape (m, n).

        Parameters
        ----------
        hypothesis : Hypothesis
            Its free parameters and effects.
        x : ndarray, shape (n,)
            Values of the free parameters.
        moves : ndarray, shape (m, n)
            Added to it, one row at a time.
        parallel : bool
            Use all simulators; False on a thread that is one of several.
        """
        points = [hypothesis.point(x + move) for move in moves]
        if parallel:
            return self.simulations.run(points)
        return [self.simulations.run_here(point) for point in points]

    def sensitivities(
        self,
        hypothesis: Hypothesis,
        x: NDArray[np.float64],
        base: Sequence[Simulated],
        which: Sequence[int],
        *,
        parallel: bool,
    ) -> list[list[tuple[NDArray[np.float64], ...]]]:
        """Change of each recording's signals per unit of some free parameters.

        Parameters
        ----------
        hypothesis : Hypothesis
            Its free parameters and effects.
        x : ndarray, shape (n,)
            Values of the free parameters.
        base : sequence of Simulated
            The recordings simulated there.
        which : sequence of int
            Places of the parameters.
        parallel : bool
            Use all simulators; False on a thread that is one of several.

        Returns
        -------
        list of list of tuple of ndarray
            For each parameter and recording, one array a signal.
        """
        steps = hypothesis.difference_sizes(x)[list(which)]
        moves = np.zeros((len(which), x.size))
        moves[range(len(which)), list(which)] = steps
        moved_runs = self.run_moved(hypothesis, x, moves, parallel=parallel)
        return [
            [
                tuple((a - b) / step for a, b in zip(run.signals, start.signals, strict=True))
                for run, start in zip(runs, base, strict=True)
            ]
            for runs, step in zip(moved_runs, steps, strict=True)
        ]

    def with_whiteners(self, whiteners: Sequence[Whitener]) -> Misfit:
        """The same recordings whitened by another budget."""
        return replace(self, whiteners=tuple(whiteners))


def chi2(blocks: Blocks) -> float:
    """Sum of squares over all windows."""
    return float(sum(np.sum(block**2) for block in blocks))
