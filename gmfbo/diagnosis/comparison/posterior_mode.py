"""Best values of a hypothesis: a Levenberg-Marquardt search through the FMU with proper priors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.numbers import AT_THE_END, SAME, SETTLED
from gmfbo.diagnosis.comparison.priors import Prior, bounds_of, priors_of, values_at
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.runs.simulated import Simulated

Array = NDArray[np.float64]

_DAMPING = 1e-3  # of a first step

_POLISHED = 6  # steps of the nuisances alone
_LONGEST_STEP = 1.0  # of a coordinate with a scale of its own, in one iteration


@dataclass(frozen=True, eq=False)
class Fitted:
    """A hypothesis at its best values.

    Attributes
    ----------
    hypothesis : Hypothesis
        With its effects at these values.
    freed : tuple of str
        Fixed parameters that it frees.
    priors : tuple of Prior
        Of its p free quantities.
    u : ndarray, shape (p,)
        Free quantities, in the coordinates of their priors.
    nuisances : ndarray, shape (q,)
        [standard deviations]
    runs : list of Simulated
        The recordings there.
    values : list of ndarray, shape (m, n)
        [SI] Simulated signals of each segment.
    residual : list of ndarray, shape (m, n)
        [SI] Recorded less simulated, less the nuisances.
    columns : list of ndarray, shape (p + q, m, n)
        Change of the signals per unit of each free quantity and nuisance.
    converged : bool
        Whether the search ended by itself.
    one_sided : ndarray of bool, shape (q,)
        Nuisances without a sign.
    """

    hypothesis: Hypothesis
    freed: tuple[str, ...]
    priors: tuple[Prior, ...]
    u: Array
    nuisances: Array
    runs: list[Simulated]
    values: list[Array]
    residual: list[Array]
    columns: list[Array]
    converged: bool
    one_sided: NDArray[np.bool_]

    @property
    def x(self) -> Array:
        """Values of the free quantities, shape (p,)."""
        return values_at(self.priors, self.u)

    @property
    def parameters(self) -> dict[str, float]:
        """Of the twin."""
        return self.hypothesis.parameters(self.x)

    @property
    def elements(self) -> frozenset[str]:
        """What it adds to the twin: effects, and freed parameters as `parameter:NAME`."""
        effects = {candidate.effect for candidate in self.hypothesis.effects}
        return frozenset(effects | {f"parameter:{name}" for name in self.freed})

    @property
    def at_zero(self) -> NDArray[np.bool_]:
        """Nuisances that rest at zero, which is a bound of those without a sign."""
        at_rest: NDArray[np.bool_] = self.nuisances == 0.0
        return at_rest & self.one_sided

    @property
    def slopes(self) -> Array:
        """Of the negative log prior in all p + q coordinates."""
        own = [p.slope(u) for p, u in zip(self.priors, self.u, strict=True)]
        return np.concatenate([own, self.nuisances])

    @property
    def curvatures(self) -> Array:
        """Of the negative log prior in all p + q coordinates."""
        own = [p.curvature(u) for p, u in zip(self.priors, self.u, strict=True)]
        return np.concatenate([own, np.ones(self.nuisances.size)])

    @property
    def log_prior(self) -> float:
        """[nats] Density of the values and nuisances."""
        own = sum(p.log_density(u) for p, u in zip(self.priors, self.u, strict=True))
        nu = self.nuisances
        return float(own - 0.5 * nu @ nu - 0.5 * nu.size * np.log(2.0 * np.pi))


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
    """

    def __init__(
        self,
        problem: Problem,
        whitening: Whitening,
        hypothesis: Hypothesis,
        freed: Sequence[str] = (),
    ) -> None:
        self._problem, self._whitening = problem, whitening
        self._hypothesis, self._freed = hypothesis, tuple(freed)
        self._priors = priors_of(hypothesis, freed)
        self._known: list[Array] | None = None
        self._normals: tuple[Array, Array] | None = None

    def fitted(
        self,
        parameters: dict[str, float],
        nuisances: Array | None = None,
        iterations: int = 10,
        settled: float = SETTLED,
    ) -> Fitted | None:
        """Search from these values of the twin's parameters; None where they cannot be simulated.

        Parameters
        ----------
        parameters : dict of str to float
            [FMU's unit] Of the twin; others start at their nominal values.
        nuisances : ndarray, shape (q,), optional
            [standard deviations] Start.
        iterations : int
            Most points with a Jacobian.
        settled : float
            [nats] Gain that is no longer worth a step.
        """
        at = self._at(self._inside(self._start(parameters)), nuisances)
        return None if at is None else self._searched(at, self._columns(at), iterations, settled)

    def again(self, row: Fitted, iterations: int = 10, settled: float = SETTLED) -> Fitted:
        """Search on from a fit under another whitening, or other noise.

        Nothing is simulated where noise and values stay.

        Parameters
        ----------
        row : Fitted
            A fit of the same hypothesis.
        iterations : int
            Most points with a Jacobian.
        settled : float
            [nats] Gain that is no longer worth a step.
        """
        if row.hypothesis.noise is self._hypothesis.noise:
            return self._searched(row, row.columns, iterations, settled)
        at = self._at(row.u, row.nuisances)
        if at is None:
            return replace(row, converged=False)
        change = [a - b for a, b in zip(at.values, row.values, strict=True)]
        if self._whitening.square(change) < SAME:
            return self._searched(at, row.columns, iterations, settled)
        return self._searched(at, self._columns(at), iterations, settled)

    def _searched(
        self, at: Fitted, columns: list[Array], iterations: int, settled: float
    ) -> Fitted:
        damping = _DAMPING
        for _ in range(iterations):
            step, gain = self._step(at, columns, damping)
            if gain < (settled if damping <= _DAMPING else AT_THE_END):
                return replace(at, columns=columns, converged=True)
            moved = self._moved(at, step)
            fall = -np.inf if moved is None else self._cost(at) - self._cost(moved)
            while fall <= 0.0 and damping < 1e4:
                damping *= 10.0
                # A short step promises little, wherever it begins.
                step, gain = self._step(at, columns, damping)
                if gain < AT_THE_END:
                    return replace(at, columns=columns, converged=True)
                moved = self._moved(at, step)
                fall = -np.inf if moved is None else self._cost(at) - self._cost(moved)
            if moved is None or fall <= 0.0:
                return replace(at, columns=columns, converged=False)
            at, damping = moved, max(0.1 * damping, 1e-7)
            columns = self._columns(at)
            if fall < AT_THE_END:
                return replace(at, columns=columns, converged=True)
        return replace(at, columns=columns, converged=False)

    def _start(self, parameters: dict[str, float]) -> Array:
        x = self._hypothesis.start(parameters)
        return np.array([p.to_u(v) for p, v in zip(self._priors, x, strict=True)])

    def _inside(self, u: Array) -> Array:
        ends = bounds_of(self._priors)
        margin = 1e-6 * (ends[:, 1] - ends[:, 0])
        return np.clip(u, ends[:, 0] + margin, ends[:, 1] - margin)

    def _at(self, u: Array, nuisances: Array | None) -> Fitted | None:
        problem = self._problem
        x = values_at(self._priors, u)
        runs = problem.simulations.run([problem.point(self._hypothesis, x)])[0]
        if not all(run.finite for run in runs):
            return None
        nu = np.zeros(len(problem.nuisances)) if nuisances is None else nuisances
        values = problem.values(runs)
        residual = problem.residual(values, nu)
        return Fitted(
            self._hypothesis.at(x),
            self._freed,
            self._priors,
            u,
            nu,
            runs,
            values,
            residual,
            [],
            False,
            problem.logging.one_sided,
        )

    def _cost(self, at: Fitted) -> float:
        """[nats] Negative log density of the recordings and the values."""
        return 0.5 * self._whitening.square(at.residual) - at.log_prior

    def _columns(self, at: Fitted) -> list[Array]:
        """Differences; those of all that is linear without noise, or its answer would be a signal.

        A loop that is sampled faster than it is logged answers noise otherwise than the twin does:
        a filter time and a gain loss were named for it (development draw, 000).
        """
        problem, x = self._problem, at.x
        sizes = self._hypothesis.difference_sizes(x)
        moves, widths, hears = [], [], self._hears_noise()
        quiet = at.values
        if self._hypothesis.noise is not None and not all(hears):
            runs = problem.simulations.run([problem.point(self._hypothesis.quiet, x)])[0]
            quiet = problem.values(runs) if all(run.finite for run in runs) else at.values
        for i, (prior, size) in enumerate(zip(self._priors, sizes, strict=True)):
            moved = x.copy()
            moved[i] += size
            if prior.logarithmic and moved[i] <= 0.0:
                moved[i] = x[i] - size
            hypothesis = self._hypothesis if hears[i] else self._hypothesis.quiet
            moves.append(problem.point(hypothesis, moved))
            widths.append(prior.to_u(moved[i]) - at.u[i])
        found = []
        moved_runs = problem.simulations.run(moves)
        for runs, width, hears_it in zip(moved_runs, widths, hears, strict=True):
            if all(run.finite for run in runs):
                base = at.values if hears_it else quiet
                change = zip(problem.values(runs), base, strict=True)
                found.append([(after - before) / width for after, before in change])
            else:
                found.append([np.zeros_like(v) for v in at.values])
        own = problem.nuisance_columns(at.values, at.nuisances)
        return [
            np.concatenate([np.reshape([f[s] for f in found], (-1, *d.shape[1:])), d])
            for s, d in enumerate(own)
        ]

    def _hears_noise(self) -> list[bool]:
        """Free quantities whose columns are those under noise: of laws that are not linear."""
        hypothesis = self._hypothesis
        own = [False] * len(hypothesis.setting.uncertain)
        for candidate in hypothesis.effects:
            own += [not candidate.law.is_linear] * len(candidate.parameters)
        return own

    def _step(self, at: Fitted, columns: list[Array], damping: float) -> tuple[Array, float]:
        """Step within the bounds, and the gain that the quadratic promises [nats]."""
        a, g = self._normal(at, columns)
        free = np.ones(g.size, dtype=bool)
        ends = bounds_of(self._priors)
        p = at.u.size
        near = 1e-5 * (ends[:, 1] - ends[:, 0])
        free[:p] &= ~((at.u <= ends[:, 0] + near) & (g[:p] < 0.0))
        free[:p] &= ~((at.u >= ends[:, 1] - near) & (g[:p] > 0.0))
        free[p:] &= ~(at.at_zero & (g[p:] < 0.0))
        step = np.zeros(g.size)
        lowest = np.full(g.size, -np.inf)
        highest = np.full(g.size, np.inf)
        lowest[:p], highest[:p] = self._inside(ends[:, 0]) - at.u, self._inside(ends[:, 1]) - at.u
        lowest[p:][at.one_sided] = -at.nuisances[at.one_sided]
        for _ in range(g.size):
            inner = a[np.ix_(free, free)]
            rest = g[free] - a[np.ix_(free, ~free)] @ step[~free]
            step[free] = np.linalg.solve(inner + damping * np.diag(np.diag(inner)), rest)
            beyond = free & ((step < lowest) | (step > highest))
            if not beyond.any():
                break
            # What meets a bound stops there, and the others make the best of it.
            step[beyond] = np.clip(step, lowest, highest)[beyond]
            free &= ~beyond
        step = np.clip(step, lowest, highest)
        bent = np.concatenate([[q.logarithmic for q in self._priors], np.ones(at.nuisances.size)])
        longest = float(np.max(np.abs(step) * bent, initial=0.0))
        step *= min(1.0, _LONGEST_STEP / longest) if longest else 1.0
        gain = float(g @ step - 0.5 * step @ a @ step)
        return step, gain

    def _normal(self, at: Fitted, columns: list[Array]) -> tuple[Array, Array]:
        if self._normals is None or self._known is not columns:
            a = np.diag(
                np.concatenate(
                    [
                        [p.curvature(u) for p, u in zip(at.priors, at.u, strict=True)],
                        np.ones(at.nuisances.size),
                    ]
                )
            )
            g = -at.slopes
            for z, j in zip(self._whitening(at.residual), self._whitening(columns), strict=True):
                flat = j.reshape(j.shape[0], -1)
                a += flat @ flat.T
                g += flat @ z.ravel()
            self._known, self._normals = columns, (a, g)
        return self._normals

    def _moved(self, at: Fitted, step: Array) -> Fitted | None:
        p = at.u.size
        nuisances = at.nuisances + step[p:]
        one_sided = self._problem.logging.one_sided
        nuisances[one_sided] = np.maximum(nuisances[one_sided], 0.0)
        moved = self._at(self._inside(at.u + step[:p]), nuisances)
        return None if moved is None else self._polished(moved)

    def _polished(self, at: Fitted) -> Fitted:
        """Let the nuisances follow, which asks for no simulation."""
        problem, one_sided = self._problem, self._problem.logging.one_sided
        cost = self._cost(at)
        for _ in range(_POLISHED):
            a, g = np.eye(at.nuisances.size), -at.nuisances
            own = problem.nuisance_columns(at.values, at.nuisances)
            for z, j in zip(self._whitening(at.residual), self._whitening(own), strict=True):
                flat = j.reshape(j.shape[0], -1)
                a = a + flat @ flat.T
                g = g + flat @ z.ravel()
            free = ~(at.at_zero & (g < 0.0))
            step = np.zeros(g.size)
            step[free] = np.linalg.solve(a[np.ix_(free, free)], g[free])
            nuisances = at.nuisances + np.clip(step, -_LONGEST_STEP, _LONGEST_STEP)
            nuisances[one_sided] = np.maximum(nuisances[one_sided], 0.0)
            residual = problem.residual(at.values, nuisances)
            tried = replace(at, nuisances=nuisances, residual=residual)
            after = self._cost(tried)
            if after >= cost:
                break
            gained, at, cost = cost - after, tried, after
            if gained < AT_THE_END:
                break
        return at
