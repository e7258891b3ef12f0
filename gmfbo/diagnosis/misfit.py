"""Whitened differences between recordings and hypotheses, and their sensitivities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.hypothesis import Hypothesis
from gmfbo.diagnosis.simulations import Simulated, Simulations
from gmfbo.diagnosis.whitening import Whitener

Blocks = tuple[NDArray[np.float64], ...]
"""Whitened values of each window, shape (..., n_residuals of that window)."""

DIFFERENCE_STEP = 5e-3
"""Share of a parameter's scale; 1e-8 would see nothing through dead bands and encoder counts."""

_TINY = 0.02  # of a step
_CLEAR = 30.0  # times what flips of encoder counts make, that a parameter's change should be


@dataclass(frozen=True, eq=False)
class Misfit:
    """Recordings against the augmented twin, window by window.

    Attributes
    ----------
    simulations : Simulations
        Who runs the twin.
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

    def sensitivities(
        self,
        hypothesis: Hypothesis,
        x: NDArray[np.float64],
        base: Sequence[Simulated],
        *,
        parallel: bool,
    ) -> list[list[tuple[NDArray[np.float64], ...]]]:
        """Change of each recording's signals per unit of each free parameter.

        Parameters
        ----------
        hypothesis : Hypothesis
            What is free.
        x : ndarray, shape (n,)
            Where.
        base : sequence of Simulated
            The recordings simulated there.
        parallel : bool
            Use all simulators; False on a thread that is one of several.

        Returns
        -------
        list of n lists, one a recording, of tuples of ndarray, one a signal
        """
        steps = self._steps(hypothesis, x)
        moved = self._moved(hypothesis, x, dict(enumerate(steps)), parallel)
        clear = self._clear_square(hypothesis, x, base, moved[0], parallel) if x.size else 0.0
        if clear > 0.0:
            squares = [chi2(self.change(moved[i], base)) for i in range(x.size)]
            wider = self._wider(hypothesis, x, steps, np.array(squares), clear)
            moved |= self._moved(hypothesis, x, wider, parallel)
            for i, step in wider.items():
                steps[i] = step
        return [
            [
                tuple((a - b) / step for a, b in zip(run.signals, start.signals, strict=True))
                for run, start in zip(moved[i], base, strict=True)
            ]
            for i, step in enumerate(steps)
        ]

    def with_whiteners(self, whiteners: Sequence[Whitener]) -> Misfit:
        """Return the same recordings measured by another budget."""
        return replace(self, whiteners=tuple(whiteners))

    def _moved(
        self,
        hypothesis: Hypothesis,
        x: NDArray[np.float64],
        steps: Mapping[int, float],
        parallel: bool,
    ) -> dict[int, list[Simulated]]:
        """The recordings simulated with each of these parameters moved by its step."""
        points = []
        for i, step in steps.items():
            moved = x.copy()
            moved[i] += step
            points.append(hypothesis.point(moved))
        if parallel:
            runs = self.simulations.run(points)
        else:
            runs = [self.simulations.run_here(point) for point in points]
        return dict(zip(steps, runs, strict=True))

    def _clear_square(
        self,
        hypothesis: Hypothesis,
        x: NDArray[np.float64],
        base: Sequence[Simulated],
        moved: Sequence[Simulated],
        parallel: bool,
    ) -> float:
        """Change of chi2 beyond which what a parameter does stands out of encoder counts.

        A smooth change grows with the square of a step, flips of counts with the step itself.
        Measured once, by the first parameter where the first fit begins.
        """
        if self.simulations.rough is None and x.size:
            tiny = float(_TINY * self._steps(hypothesis, x)[0])
            near = self._moved(hypothesis, x, {0: tiny}, parallel)[0]
            self.simulations.rough = [
                [
                    tuple(a - b for a, b in zip(run.signals, start.signals, strict=True))
                    for run, start in zip(runs, base, strict=True)
                ]
                for runs in (near, moved)
            ]
        if self.simulations.rough is None:
            return 0.0
        small, whole = (chi2(self.whitened(columns)) for columns in self.simulations.rough)
        flips = max(0.0, small - _TINY**2 * whole)
        return float((_CLEAR * flips / _TINY) ** 2 / whole) if whole > 0.0 else 0.0

    def _wider(
        self,
        hypothesis: Hypothesis,
        x: NDArray[np.float64],
        steps: NDArray[np.float64],
        squares: NDArray[np.float64],
        clear: float,
    ) -> dict[int, float]:
        """Steps of those parameters whose change does not stand out of encoder counts.

        A column of noise makes Gauss-Newton steps too short, and a fit ends where it began.
        """
        low, high = hypothesis.bounds
        most = np.minimum(hypothesis.scales, 0.3 * (high - low))
        wider = {}
        for i, (step, square) in enumerate(zip(steps, squares, strict=True)):
            if not 0.0 < square < clear:
                continue
            size = min(abs(step) * float(np.sqrt(clear / square)), float(most[i]))
            if size > abs(step):
                wider[i] = -size if x[i] + size > high[i] else size
        return wider

    def _steps(self, hypothesis: Hypothesis, x: NDArray[np.float64]) -> NDArray[np.float64]:
        low, high = hypothesis.bounds
        sizes = DIFFERENCE_STEP * np.maximum(np.abs(x), hypothesis.scales)
        sizes = np.minimum(sizes, 0.3 * (high - low))
        return np.where(x + sizes > high, -sizes, sizes)


def chi2(blocks: Blocks) -> float:
    """Sum of squares over all windows."""
    return float(sum(np.sum(block**2) for block in blocks))
