"""A chosen hypothesis fitted to some stretches alone, and what it foretells on others."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.fitted_starts import at_own_starts
from gmfbo.diagnosis.comparison.evidence import (
    LEAST_STRETCHES,
    Grams,
    grams,
    tilted_parabola,
    weightings,
)
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.modes.posterior_mode import ModeSearch
from gmfbo.diagnosis.comparison.numbers import AT_THE_END
from gmfbo.diagnosis.comparison.opened_comparison import held_at_rest, kernels_of, problem_on
from gmfbo.diagnosis.comparison.own_parts import beside_own_parts_on
from gmfbo.diagnosis.comparison.priors import bounds_of, values_at
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.search import Search
from gmfbo.diagnosis.comparison.simulation_errors import errors_of
from gmfbo.diagnosis.comparison.starting.other_modes import other_modes, shares_of
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.fitting.intervals import TWO_SIDED

Array = NDArray[np.float64]

_DRAWN = 2000  # values of a mixture of modes
_RIDGE = 1e-9  # of correlations: quantities may be the same to the recordings


@dataclass(frozen=True, eq=False)
class Part:
    """A hypothesis on some windows of a case.

    Attributes
    ----------
    problem : Problem
        These windows.
    whitening : Whitening
        By the levels of the whole comparison.
    fitted : Fitted
        The hypothesis there.
    modes : tuple of Fitted
        Fits of it that began far from there and that these windows may like as much.
    """

    problem: Problem
    whitening: Whitening
    fitted: Fitted
    modes: tuple[Fitted, ...] = ()

    def with_other_modes(self) -> Part:
        """The same with other values that are found; told are those that the search came to."""
        return replace(self, modes=tuple(other_modes(self.problem, self.whitening, self.fitted)))

    def intervals(self) -> tuple[Array, Array, Array]:
        """Standard deviations and ends of 95 % intervals of the free quantities.

        The larger of two: of the posterior's parabola, and of a Bayesian bootstrap over stretches
        (Huggins and Miller 2023), which holds where the remainder is more than noise. With other
        modes they are those of the mixture. They reach to where values would be with an infinitely
        short step of the simulation.

        Returns
        -------
        tuple of ndarray, shape (p,)
            [unit of each quantity]
        """
        fitted = self.fitted
        p = fitted.u.size
        if not p:
            empty = np.zeros(0)
            return empty, empty, empty
        whitening = fitted.beside_own_parts(self.whitening)
        inner = grams(self.problem, whitening, fitted)
        a = inner.matrices.sum(0) + np.diag(fitted.curvatures)
        moved = self._moved_by_the_step(whitening, a)[:p]
        low, high = self._within(inner)
        limits = bounds_of(fitted.priors)
        half = 0.5 * (high - low)
        low = np.clip(low + np.minimum(moved, 0.0), limits[:, 0], limits[:, 1])
        high = np.clip(high + np.maximum(moved, 0.0), limits[:, 0], limits[:, 1])
        x, low_x, high_x = (values_at(fitted.priors, u) for u in (fitted.u, low, high))
        slope = np.array(
            [v if q.logarithmic else 1.0 for q, v in zip(fitted.priors, x, strict=True)]
        )
        return np.abs(slope) * half / TWO_SIDED, low_x, high_x

    def log_odds_against(self, values: Array) -> float:
        """[nats] Odds that free quantities lie elsewhere, against some values (Dickey 1971).

        The prior's density there over the posterior's, which is as wide as the intervals before
        the step of the simulation is allowed for, and correlated as the parabola says: of all
        quantities together, or of the one that says most.

        Parameters
        ----------
        values : ndarray, shape (p,)
            In the coordinates of the priors.
        """
        fitted, p = self.fitted, self.fitted.u.size
        if not p:
            return 0.0
        inner = grams(self.problem, fitted.beside_own_parts(self.whitening), fitted)
        low, high = self._within(inner)
        covariance = _covariance(fitted, inner)
        deviations, spreads = 0.5 * (high - low) / TWO_SIDED, np.sqrt(np.diag(covariance))
        alike = covariance / np.outer(spreads, spreads) + _RIDGE * np.eye(p)
        before = [q.log_density(float(v)) for q, v in zip(fitted.priors, values, strict=True)]
        alone = np.array(before) - norm.logpdf(values, fitted.u, deviations)
        factor = np.linalg.cholesky(alike)
        z = np.linalg.solve(factor, (values - fitted.u) / deviations)
        after = norm.logpdf(z).sum() - np.log(np.diag(factor) * deviations).sum()
        return float(max(sum(before) - after, alone.max()))

    def _within(self, inner: Grams) -> tuple[Array, Array]:
        """Ends of 95 % of the mixture of all modes, in the coordinates of the priors."""
        halves = [_half_of(self.fitted, inner)]
        if not self.modes:
            return self.fitted.u - halves[0], self.fitted.u + halves[0]
        modes = [self.fitted, *self.modes]
        for mode in self.modes:
            whitening = mode.beside_own_parts(self.whitening)
            halves.append(_half_of(mode, grams(self.problem, whitening, mode)))
        shares = shares_of(self.problem, self.whitening, modes)
        counts = np.round(shares * _DRAWN).astype(int)
        drawn = [
            mode.u + half / TWO_SIDED * norm.ppf((np.arange(count)[:, None] + 0.5) / count)
            for mode, half, count in zip(modes, halves, counts, strict=True)
            if count
        ]
        low, high = np.quantile(np.concatenate(drawn), [0.025, 0.975], axis=0)
        return np.minimum(low, self.fitted.u), np.maximum(high, self.fitted.u)

    def _moved_by_the_step(self, whitening: Whitening, curvature: Array) -> Array:
        """By how much an infinitely short step would move the quantities and nuisances, shape (n,).

        Physics that is coupled to a twin acts a step late: a spring looks like negative drag. Half
        the step takes half of that away (Richardson 1911).
        """
        fitted, problem = self.fitted, self.problem
        point = problem.point(fitted.hypothesis, fitted.x, fitted.own_values)
        runs = problem.simulations.run([point])[0]
        slope = np.zeros(len(curvature))
        changes = [own for own in problem.simulations.step_errors(point, runs) if own is not None]
        if len(changes) < len(runs):
            return slope
        pairs = zip(runs, changes, strict=True)
        halved = problem.values([replace(run, signals=own) for run, own in pairs])
        for j, z in zip(whitening(fitted.columns), whitening(halved), strict=True):
            slope -= j.reshape(len(slope), -1) @ z.ravel()
        return np.asarray(2.0 * np.linalg.solve(curvature, slope), dtype=np.float64)


def _covariance(fitted: Fitted, inner: Grams) -> Array:
    """Of the posterior's parabola, of the free quantities alone, shape (p, p)."""
    p = fitted.u.size
    a = inner.matrices.sum(0) + np.diag(fitted.curvatures)
    return np.asarray(np.linalg.inv(a)[:p, :p], dtype=np.float64)


def _half_of(fitted: Fitted, inner: Grams) -> Array:
    """Half widths of a fit's own intervals, in the coordinates of its priors, shape (p,)."""
    p = fitted.u.size
    half = TWO_SIDED * np.sqrt(np.diag(_covariance(fitted, inner)))
    if len(inner.squares) >= LEAST_STRETCHES:
        moves = tilted_parabola(fitted, inner, weightings(len(inner.squares)))[0][:, :p]
        ends = np.quantile(np.abs(moves - moves.mean(0)), 0.95, axis=0)
        half = np.maximum(half, ends)
    return np.asarray(half, dtype=np.float64)


def ledger_on(unseen: Case, search: Search, ledger: Ledger, row: Fitted) -> Ledger:
    """A ledger whose paths of noise, and errors of the simulation, are those of other recordings.

    They may have other gains. What the logger may have averaged is free in the recordings that were
    compared, and so it is here: else a fit's shift of a column that stands for it would count.

    Parameters
    ----------
    unseen : Case
        The other recordings.
    search : Search
        Whose twin it is.
    ledger : Ledger
        Of those that were compared.
    row : Fitted
        About which the paths are measured.
    """
    problem = problem_on(unseen, unseen.budget.windows, search.problem.encoder)
    kernels = kernels_of(unseen, problem)(row)
    level = ledger.levels.ports.get("sensor", 0.0)
    point = problem.point(row.hypothesis, row.x)
    errors = errors_of(unseen.simulations, point, kernels, level, held_at_rest(unseen))
    return replace(ledger, kernels=kernels, errors=errors.as_of(ledger.errors))


def foretelling(search: Search, ledger: Ledger, row: Fitted) -> Ledger:
    """A ledger with the errors of a simulation to which all noise is unknown.

    A recording that is foretold has noise of its own, which no fit has heard.

    Parameters
    ----------
    search : Search
        Whose problem it is.
    ledger : Ledger
        With the errors about a row.
    row : Fitted
        Which foretells.
    """
    if ledger.noise is None and not ledger.own_noise:
        return ledger
    errors = search.noise.errors(replace(row, heard=None), ledger.kernels, ledger.levels)
    return replace(ledger, errors=errors.as_of(ledger.errors))


def part_of(
    case: Case, search: Search, ledger: Ledger, row: Fitted, windows: Sequence[int]
) -> Part:
    """Fit a hypothesis to some windows alone.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    search : Search
        Whose problem it is.
    ledger : Ledger
        Levels of noise and paths.
    row : Fitted
        The hypothesis, fitted to all windows.
    windows : sequence of int
        Those that are fitted, in order.
    """
    part = _stated_on(case, search, ledger, row, windows)
    fit = ModeSearch(part.problem, part.whitening, row.hypothesis, row.freed, row.heard)
    found = fit.fitted(row.parameters, row.nuisances, iterations=20, settled=AT_THE_END, near=row)
    return part if found is None else replace(part, fitted=found)


def seen_on(
    case: Case,
    search: Search,
    ledger: Ledger,
    row: Fitted,
    windows: Sequence[int],
    about: Sequence[Fitted],
    inadequacy: float = 0.0,
) -> Part:
    """State a fit on other windows, at its values.

    Parameters
    ----------
    case, search, ledger, row, windows
        As of `part_of`.
    about : sequence of Fitted
        Fits to all windows, whose quantities have own parts in each recording.
    inadequacy : float
        [FMU's unit of the torque port] Size of the smooth torque that may be left.
    """
    part = _stated_on(case, search, ledger, row, windows, inadequacy)
    whitening = beside_own_parts_on(part.whitening, part.problem, search.problem, about)
    return replace(part, whitening=whitening)


def _stated_on(
    case: Case,
    search: Search,
    ledger: Ledger,
    row: Fitted,
    windows: Sequence[int],
    inadequacy: float = 0.0,
) -> Part:
    chosen = [case.budget.windows[i] for i in windows]
    problem = replace(
        problem_on(case, chosen, search.problem.encoder),
        logging=search.problem.logging,
        followed=None if search.problem.followed is None else ledger.kernels,
        held_inertia=search.problem.held_inertia,
    )
    values = problem.values(row.runs)
    residual = problem.residual(values, row.nuisances)
    there = replace(row, values=values, residual=residual, columns=[])
    noise = replace(search.noise, problem=problem)
    whitening = noise.whitening(there, ledger.kernels, ledger.levels, ledger.errors, inadequacy)
    return Part(problem, whitening, there)


def quiet(
    case: Case, row: Fitted, told_by: Collection[int] = (), problem: Problem | None = None
) -> Fitted:
    """A fit without the noise that its recordings hold, as it foretells what is not known.

    Parameters
    ----------
    case : Case
        With the recordings that are foretold.
    row : Fitted
        At its values.
    told_by : collection of int
        Windows that tell where their recordings start, where starts are fitted.
    problem : Problem, optional
        Whose score it gets: without the counts of an encoder that its levels hold as noise.
    """
    point = at_own_starts(case, row.hypothesis.point(row.x), told_by)
    if problem is not None:
        point = problem.without_counts(point)
    runs = case.simulations.run([point])[0]
    return replace(row, runs=runs, own=np.zeros((0, 0)), heard=None)


def squares_on(
    search: Search, ledger: Ledger, parts: Sequence[Part], about: Sequence[Fitted]
) -> Array:
    """Whitened squares by noise alone, shape (1 + n_parts, n_stretches).

    The first row is what noise gives: the number of whitened values.

    Parameters
    ----------
    search, ledger
        As of `part_of`.
    parts : sequence of Part
        Fits stated on the same windows; noise is whitened about the last one.
    about : sequence of Fitted
        As of `seen_on`.
    """
    there = replace(search.noise, problem=parts[0].problem)
    whitening = there.quiet(parts[-1].fitted, ledger)
    whitening = beside_own_parts_on(whitening, parts[0].problem, search.problem, about)
    whitened = [whitening(part.fitted.residual) for part in parts]
    counted = [[(z != 0.0).astype(float) for z in whitened[0]]]
    squared = [[z**2 for z in zs] for zs in whitened]
    summed = parts[0].problem.by_stretch
    return np.array([np.concatenate(summed(values)) for values in (*counted, *squared)])


def gains_on(before: Part, after: Part) -> Array:
    """[nats] What one fit has more log density than another on the same stretches, shape (n,).

    Parameters
    ----------
    before, after : Part
        Stated on the same windows.
    """
    first, second = (
        np.concatenate(
            before.problem.by_stretch([z**2 for z in before.whitening(part.fitted.residual)])
        )
        for part in (before, after)
    )
    fallen: Array = 0.5 * (first - second)
    return fallen
