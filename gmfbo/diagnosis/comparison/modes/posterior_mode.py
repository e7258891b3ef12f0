"""Best values of a hypothesis: a Levenberg-Marquardt search through the FMU with proper priors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.evidence import grams
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.heard_noise import HeardNoise
from gmfbo.diagnosis.comparison.modes.nuisance_steps import LONGEST_STEP, WhiteResiduals, polished
from gmfbo.diagnosis.comparison.modes.trial_points import TrialPoints
from gmfbo.diagnosis.comparison.numbers import (
    AT_THE_END,
    FAR_BEHIND,
    HOPED_STEPS,
    MOST,
    SAME,
    SETTLED,
)
from gmfbo.diagnosis.comparison.own_parts import (
    Eliminated,
    by_recording,
    eliminated,
    without_own_parts,
)
from gmfbo.diagnosis.comparison.priors import bounds_of, inside
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.fitting.bounded_step import bounded_step
from gmfbo.diagnosis.fitting.difference_steps import MUCH_SHOWN
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis

Array = NDArray[np.float64]

_DAMPING, _MOST_DAMPING = 1e-3, 1e4  # of a first step, and of the shortest


@dataclass(frozen=True, eq=False)
class _Step:
    """Change of all coordinates, the gain that the quadratic promises [nats], and its damping."""

    change: Array
    gain: float
    damping: float


class ModeSearch:
    """Levenberg-Marquardt steps of one hypothesis under one whitening.

    Parameters
    ----------
    problem : Problem
        Recordings and simulators.
    whitening : Whitening
        By noise and the inadequacy that all hypotheses share.
    hypothesis : Hypothesis
        Its effects' values are the start.
    freed : sequence of str
        Those of its parameters that the twin file holds fixed.
    heard : HeardNoise, optional
        Under which the recordings are simulated.
    """

    def __init__(
        self,
        problem: Problem,
        whitening: Whitening,
        hypothesis: Hypothesis,
        freed: Sequence[str] = (),
        heard: HeardNoise | None = None,
    ) -> None:
        self._problem, self._whitening, self._heard = problem, whitening, heard
        self._points = TrialPoints(problem, hypothesis, freed, heard)
        self._normals: tuple[list[Array], Array, Array] | None = None
        self._whites, self._nuisance_columns = WhiteResiduals(whitening), list[Array]()
        self._spread = np.array([whitening.spreads.get(n, 0.0) for n in hypothesis.names], float)
        self._places = np.flatnonzero(self._spread)
        self._parts: Eliminated | None = None
        self._judged_once: set[str] = set()  # quantities

    def fitted(
        self,
        parameters: dict[str, float],
        nuisances: Array | None = None,
        iterations: int = 10,
        settled: float = SETTLED,
        near: Fitted | None = None,
        rival: float = np.inf,
    ) -> Fitted | None:
        """Search from these values of the twin's parameters; None where they cannot be simulated.

        Parameters
        ----------
        parameters : dict of str to float
            [FMU's unit] Of the twin; others start at their nominal values.
        nuisances : ndarray, shape (q,), optional
            [standard deviations] Start.
        iterations : int
            Most points with a Jacobian, but for those on the way from a start that is far off.
        settled : float
            [nats] Gain that is no longer worth a step.
        near : Fitted, optional
            Whose own parts are a start.
        rival : float
            [nats] Cost of the best fit so far: what stays far behind it is not searched on.
        """
        at = self.begun(parameters, nuisances, near)
        return None if at is None else self.fitted_from(at, iterations, settled, rival)

    def begun(
        self, parameters: dict[str, float], nuisances: Array | None, near: Fitted | None
    ) -> Fitted | None:
        """Where a search with these arguments of `fitted` begins, without columns."""
        start = self._points.start(parameters)
        return self._points.at(start, nuisances, self._own_near(near))

    def fitted_from(
        self, at: Fitted, iterations: int = 10, settled: float = SETTLED, rival: float = np.inf
    ) -> Fitted:
        """Search from there, with the other arguments of `fitted`."""
        at = self._points.with_clear_steps(at, self._whitening.square)
        return self._searched(at, self._points.columns(at), iterations, settled, rival)

    def again(
        self, row: Fitted, iterations: int = 10, settled: float = SETTLED, rival: float = np.inf
    ) -> Fitted:
        """Search on from a fit under another whitening, or other noise.

        Nothing is simulated where noise and values stay, and a fit that converged under the same
        whitening and noise is that fit.

        Parameters
        ----------
        row : Fitted
            A fit of the same hypothesis.
        iterations : int
            Most points with a Jacobian, but for those on the way from a start that is far off.
        settled : float
            [nats] Gain that is no longer worth a step.
        rival : float
            [nats] As of `fitted`.
        """
        is_known = row.under is self._whitening and row.heard is self._heard
        if is_known and row.converged and settled >= SETTLED:
            return row
        own = self._own_near(row)
        residual = without_own_parts(self._problem, row.residual, row.columns, -row.own)
        if row.heard is self._heard and np.array_equal(own, row.own):
            there = replace(row, residual=residual)
            return self._searched(there, row.columns, iterations, settled, rival)
        at = self._points.at(row.u, row.nuisances, own)
        if at is None:
            return replace(row, converged=False)
        before = replace(row, residual=residual)
        if self._squared_change(at, before) < SAME:
            at = replace(at, columns_at=self._measured_at(before).residual)
            return self._searched(at, row.columns, iterations, settled, rival)
        return self._searched(at, self._points.columns(at), iterations, settled, rival)

    def _searched(
        self, at: Fitted, columns: list[Array], iterations: int, settled: float, rival: float
    ) -> Fitted:
        damping, cost, spent, measured = _DAMPING, self.cost(at), 0, self._measured_at(at)
        is_rival = rival < np.inf
        while spent < iterations:
            before = columns
            at, columns = self._with_finer_steps(at, before)
            if columns is not before:
                measured = at
            step, gain = self._step(at, columns, damping)
            # A damped step is short, and promises little wherever it begins.
            promised = gain if damping <= _DAMPING else self._step(at, columns, _DAMPING)[1]
            if cost - HOPED_STEPS * promised > rival + FAR_BEHIND:
                return self._ended(at, columns, False, measured)
            # Of rivals of the best fit, columns that are exact enough for a step are enough.
            is_exact = is_rival or self._squared_change(at, measured) <= settled
            if promised < settled and is_exact:
                return self._ended(at, columns, True, measured)
            if gain < AT_THE_END:
                damping = _DAMPING
                step, gain = self._step(at, columns, damping)
            lower = None
            if promised >= settled:
                lower = self._lower(at, columns, _Step(step, gain, damping), cost, settled)
            if lower is None and not is_exact:  # exact columns may promise more
                columns, measured, damping = self._points.columns(at), at, _DAMPING
                continue
            if lower is None:
                return self._ended(at, columns, promised < FAR_BEHIND, measured)
            at, taken = lower
            higher, cost = cost, self.cost(at)
            fall = higher - cost
            # Steps from a start that is far off do not count: `iterations` like this one would
            # take all of the cost.
            spent += not (fall * iterations > higher > 0.0)
            damping = max(0.1 * taken.damping, 1e-7)
            # Columns are exact enough for a chord step (Ortega, Rheinboldt 1970, section 7.1).
            is_near = self._squared_change(at, measured) < SAME * settled / SETTLED
            if is_near and fall >= AT_THE_END and (is_rival or spent < iterations):
                columns = self._points.renewed(at, columns)
            else:
                columns, measured = self._points.columns(at), at
            if fall < AT_THE_END:
                return self._ended(at, columns, True, measured)
        return self._ended(at, columns, False, measured)

    def _measured_at(self, at: Fitted) -> Fitted:
        """The same, as it was where its columns were measured."""
        return replace(at, residual=at.columns_at) if at.columns_at else at

    def _squared_change(self, at: Fitted, before: Fitted) -> float:
        """Whitened square of the difference of what two fits leave, and so predict."""
        if at is before:
            return 0.0
        return self._whitening.square(
            [a - b for a, b in zip(at.residual, before.residual, strict=True)]
        )

    def _lower(
        self, at: Fitted, columns: list[Array], step: _Step, cost: float, settled: float
    ) -> tuple[Fitted, _Step] | None:
        """Where a step leads down, and that step or a shorter one; None where none does."""
        missed, alike = np.inf, False
        while True:
            moved = self._moved(at, step.change, step.damping)
            after = np.inf if moved is None else self.cost(moved)
            if moved is not None and after < cost:
                return moved, step
            if step.damping >= _MOST_DAMPING:
                return None
            before, missed = missed, step.gain + after - cost
            once, alike = alike, bool(missed > MOST * before)
            step = self._shorter(at, columns, step)
            # Where a cost is smooth a shorter step misses less. Friction makes it rough.
            if step.gain < settled or (once and alike):
                return None

    def _with_finer_steps(self, at: Fitted, columns: list[Array]) -> tuple[Fitted, list[Array]]:
        """The same, with shorter differences where a law bends within the usual ones."""
        points = self._points
        if points.is_shuffled:
            return at, columns
        sizes = np.sqrt(np.diag(self._normal(at, columns)[0])[: at.u.size])
        shares = np.abs(points.aside(at) - at.u) * sizes
        shown = zip(points.hypothesis.names, points.hypothesis.bent, shares, strict=True)
        large = {n: float(s) for n, bends, s in shown if bends and s > MUCH_SHOWN}
        fresh = {n: s for n, s in large.items() if n not in self._judged_once}
        self._judged_once |= large.keys()
        if not points.shorten_steps(at, fresh, self._whitening.square):
            return at, columns
        return points.restated(at), points.columns(at)

    def _shorter(self, at: Fitted, columns: list[Array], step: _Step) -> _Step:
        """A step that promises half as much at most: one like that which failed fails too."""
        change, gain, damping = np.zeros(0), np.inf, step.damping
        while gain > 0.5 * step.gain and damping < _MOST_DAMPING:
            damping *= 2.0
            change, gain = self._step(at, columns, damping)
        return _Step(change, gain, damping)

    def _ended(
        self, at: Fitted, columns: list[Array], converged: bool, measured: Fitted | None = None
    ) -> Fitted:
        residual = without_own_parts(self._problem, at.residual, columns, at.own)
        return replace(
            at,
            residual=residual,
            columns=columns,
            converged=converged,
            under=self._whitening,
            columns_at=[] if measured is None or measured is at else measured.residual,
        )

    def _own_near(self, row: Fitted | None) -> Array:
        """Own parts of another fit, of the quantities that have any here."""
        count = len(self._problem.simulations.records)
        if row is None or len(row.own) != count:
            return np.zeros((count, self._spread.size))
        return np.where(self._spread > 0.0, row.own_of(self._points.hypothesis.names), 0.0)

    def cost(self, at: Fitted) -> float:
        """[nats] Negative log density of the recordings and the values."""
        own = at.own[:, self._places] / self._spread[self._places]
        return 0.5 * (self._whites.square(at) + float(np.sum(own**2))) - at.log_prior

    def _step(self, at: Fitted, columns: list[Array], damping: float) -> tuple[Array, float]:
        """Step within the bounds, and the gain that the quadratic promises [nats]."""
        a, g = self._normal(at, columns)
        free = np.ones(g.size, dtype=bool)
        ends = bounds_of(self._points.priors)
        p, near = at.u.size, 1e-5 * (ends[:, 1] - ends[:, 0])
        free[:p] &= ~((at.u <= ends[:, 0] + near) & (g[:p] < 0.0))
        free[:p] &= ~((at.u >= ends[:, 1] - near) & (g[:p] > 0.0))
        free[p:] &= ~(at.at_zero & (g[p:] < 0.0))
        lowest, highest = np.full((2, g.size), np.inf) * [[-1.0], [1.0]]
        lowest[:p], highest[:p] = (inside(self._points.priors, end) - at.u for end in ends.T)
        lowest[p:][at.one_sided] = -at.nuisances[at.one_sided]
        bent = np.concatenate([[q.logarithmic for q in self._points.priors], at.one_sided])
        lowest = np.where(bent, np.maximum(lowest, -LONGEST_STEP), lowest)
        highest = np.where(bent, np.minimum(highest, LONGEST_STEP), highest)
        damped = a + damping * np.diag(np.diag(a))
        step = bounded_step(damped, g, free, lowest, highest)
        gain = float(g @ step - 0.5 * step @ a @ step)
        if self._parts is not None:
            gain += self._parts.gain(at.own[:, self._places], damping)
        return step, gain

    def _normal(self, at: Fitted, columns: list[Array]) -> tuple[Array, Array]:
        if self._normals is None or self._normals[0] is not columns:
            a, g, p = np.diag(at.curvatures), -at.slopes, at.u.size
            if self._places.size:
                self._nuisance_columns = self._whitening([c[p:] for c in columns])
                there = self._ended(at, columns, False)
                inner = by_recording(self._problem, grams(self._problem, self._whitening, there))
                self._parts = eliminated(*inner, self._places, self._spread[self._places])
                a, g = a + self._parts.matrix, g + self._parts.product
            else:
                white = self._whitening(columns)
                self._nuisance_columns = [j[p:] for j in white]
                for z, j in zip(self._whites.of(at), white, strict=True):
                    flat = j.reshape(j.shape[0], -1)
                    a += flat @ flat.T
                    g += flat @ z.ravel()
            self._normals = columns, a, g
        return self._normals[1:]

    def _moved(self, at: Fitted, step: Array, damping: float) -> Fitted | None:
        p, own, one_sided = at.u.size, at.own.copy(), self._problem.logging.one_sided
        if self._parts is not None:
            own[:, self._places] = self._parts.moved(own[:, self._places], step, damping)
        nuisances = at.nuisances + step[p:]
        nuisances[one_sided] = np.maximum(nuisances[one_sided], 0.0)
        moved = self._points.at(inside(self._points.priors, at.u + step[:p]), nuisances, own)
        if moved is None:
            return None
        return polished(self._problem, self._whites, self._nuisance_columns, moved, self.cost)
