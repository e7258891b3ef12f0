"""A row of the comparison with a free function at a port, fitted through the simulators."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.special import logsumexp

from gmfbo.diagnosis.comparison.evidence import grams, log_evidences
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.modes.nuisance_steps import LONGEST_STEP
from gmfbo.diagnosis.comparison.moves import Element
from gmfbo.diagnosis.comparison.own_parts import without_own_parts
from gmfbo.diagnosis.comparison.priors import bounds_of, coordinates_of, inside
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.unknown.kinds import Kind
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.runs.simulated import Simulated

Array = NDArray[np.float64]

_SIZES = 4.0 ** np.arange(8.0)  # of the function, times the tolerance: to all that a drive can do
_STEPS = 12  # most that are taken
_DAMPINGS = (0.0, 1e-3, 0.03, 1.0)  # of a step, until one is better
WORTH = 0.5
"""[nats] Gain that is worth another point: what tells is 2.94."""
_FAR = 10.0  # [nats] below the best size, one does not count


@dataclass(frozen=True, eq=False)
class Sized:
    """Evidence with a free function of each size.

    Attributes
    ----------
    log_evidences : ndarray, shape (n_weightings,)
        [nats] The size integrated out; its logarithm is uniform.
    size : float
        [FMU's unit of the torque port] The most probable one.
    amplitudes : ndarray, shape (c,)
        Of the functions, as a straight line tells them under that size.
    """

    log_evidences: Array
    size: float
    amplitudes: Array


@dataclass(frozen=True, eq=False)
class WithUnknown:
    """A row with a free function beside it.

    Attributes
    ----------
    kind : Kind
        Of the function.
    columns : list of ndarray, shape (c, m, n)
        [SI] By segment: what the kind's functions cause, of a unit size of the whole.
    left : Fitted
        The row at its values, and what it leaves with the function.
    amplitudes : ndarray, shape (c,)
        Of the functions.
    """

    kind: Kind
    columns: list[Array]
    left: Fitted
    amplitudes: Array

    @property
    def row(self) -> Fitted:
        """The row at its values, and what it leaves without the function."""
        parts = zip(self.left.residual, self.columns, strict=True)
        made = [z + np.tensordot(self.amplitudes, c, 1) for z, c in parts]
        return replace(self.left, residual=made)

    @property
    def effective(self) -> float:
        """[FMU's unit of the torque port] Root mean square of the function in the recordings."""
        played = np.concatenate([self.amplitudes @ signals for signals in self.kind.signals])
        return float(np.sqrt(np.mean(played**2))) / self.kind.unit

    def blocks(self, whitening: Whitening) -> list[Array]:
        """Whitened changes per quantity and nuisance of the row, then per function, by segment.

        Parameters
        ----------
        whitening : Whitening
            By noise, with the row's own parts beside.

        Returns
        -------
        list of ndarray, shape (p + q + c, m n)
        """
        pairs = zip(whitening(self.left.columns), whitening(self.columns), strict=True)
        return [np.concatenate([a, b]).reshape(len(a) + len(b), -1) for a, b in pairs]

    def sized(
        self,
        problem: Problem,
        whitening: Whitening,
        weights: Array,
        tolerance: float,
        white: Sequence[Array] | None = None,
    ) -> Sized:
        """Evidence of the recordings.

        Parameters
        ----------
        problem : Problem
            Recordings.
        whitening : Whitening
            By noise.
        weights : ndarray, shape (n_weightings, n_stretches)
            Of the stretches.
        tolerance : float
            [FMU's unit of the torque port] Size about which nobody cares.
        white : sequence of ndarray, shape (c, m, n), optional
            The columns, whitened already, but for own parts.
        """
        row = self.row
        own = row.beside_own_parts(whitening)
        bumps = own.of_own(white or whitening(self.columns))
        inner = grams(problem, own, row, bumps, are_free=True)
        sizes, count = tolerance * _SIZES, len(self.amplitudes)
        mean = weights.mean(0, keepdims=True)
        first = np.array([log_evidences(row, inner, mean, count, s)[0] for s in sizes])
        kept = np.flatnonzero(first > first.max() - _FAR)
        if len(weights) == 1:
            logs = first[kept][:, None]
        else:
            logs = np.stack([log_evidences(row, inner, weights, count, s) for s in sizes[kept]])
        total = logsumexp(logs, axis=0)
        size = float(sizes[np.argmax(first)])
        prior = np.concatenate([row.curvatures, np.full(count, size**-2)])
        slopes = (mean @ inner.products)[0]
        slopes[: -count or None] -= row.slopes
        moved = np.linalg.solve(np.tensordot(mean, inner.matrices, 1)[0] + np.diag(prior), slopes)
        return Sized(total - np.log(len(sizes)), size, moved[moved.size - count :])


def of_unit_size(kind: Kind, energy: float, own: float) -> Kind | None:
    """A kind whose functions are of unit size; None where they show nothing.

    At the torque port they are of unit size as they are. At another port they are where they show
    as much.

    Parameters
    ----------
    kind : Kind
        As it was made.
    energy : float
        Whitened square that functions of unit size have at the torque port.
    own : float
        Whitened square of what the kind's functions cause.
    """
    if own <= 0.0:
        return None
    factor = 1.0 if kind.port == "torque" else np.sqrt(energy / own)
    return replace(kind, signals=[factor * s for s in kind.signals], unit=float(factor))


def fitted_with(
    problem: Problem, whitening: Whitening, row: Fitted, start: WithUnknown, size: float
) -> WithUnknown:
    """Fit a row and a free function beside it, whose signals are played into the twin.

    The columns stay those about the row, so that a step costs one point. Each is simulated.

    Parameters
    ----------
    problem : Problem
        Recordings and simulators.
    whitening : Whitening
        By noise alone.
    row : Fitted
        The row without it.
    start : WithUnknown
        Where the fit begins.
    size : float
        [FMU's unit of the torque port] Standard deviation of the amplitudes.
    """
    whitening, heard = row.beside_own_parts(whitening), _heard(problem, row, start.kind)
    flat = start.blocks(whitening)
    prior = np.concatenate([row.curvatures, np.full(len(start.amplitudes), size**-2)])
    matrix = sum((j @ j.T for j in flat), np.diag(prior))
    at, cost = start, _cost(whitening, start, size)
    for _ in range(_STEPS):
        white = whitening(at.left.residual)
        slope = sum((j @ z.ravel() for j, z in zip(flat, white, strict=True)), np.zeros(len(prior)))
        slope -= np.concatenate([at.left.slopes, at.amplitudes / size**2])
        better, ends = None, _longest_steps(at)
        for damping in _DAMPINGS:
            step = _step(matrix + damping * np.diag(np.diag(matrix)), slope, ends)
            if slope @ step - 0.5 * step @ matrix @ step < WORTH:
                break
            tried = _moved(problem, at, step, heard)
            after = np.inf if tried is None else _cost(whitening, tried, size)
            if after < cost:
                better = tried
                break
        if better is None:
            break
        fall, at, cost = cost - after, better, after
        if fall < WORTH:
            break
    return at


def begun_as(problem: Problem, larger: Fitted, smaller: WithUnknown) -> WithUnknown | None:
    """A larger row where a smaller one with its function ended, and what it adds next to nothing.

    Parameters
    ----------
    problem : Problem
        Recordings and simulators.
    larger : Fitted
        A row without a function, at its own values.
    smaller : WithUnknown
        Fitted; the row of some of its elements.

    Returns
    -------
    WithUnknown or None
        With the columns of the larger row; None where the twin cannot be simulated there.
    """
    begun = {c.effect: c for c in smaller.left.hypothesis.at(smaller.left.x).effects}
    hypothesis, effects = larger.hypothesis, list[Candidate]()
    for own in hypothesis.at(larger.x).effects:
        element = Element(candidate=own)
        nothing = element.moved(0.0, dict.fromkeys(element.sizes(hypothesis), 0.0), hypothesis)
        same = begun.get(own.effect, nothing.candidate)
        assert same is not None
        effects.append(own.with_values({n: same.values.get(n, v) for n, v in own.values.items()}))
    usual = {one.name: one.nominal for one in hypothesis.setting.uncertain}
    begins = replace(hypothesis, effects=tuple(effects))
    x = begins.start({**usual, **smaller.left.parameters})
    u = inside(larger.priors, coordinates_of(larger.priors, x))
    left = replace(larger, u=u, nuisances=smaller.left.nuisances)
    at = replace(smaller, left=left)
    nowhere = np.zeros(u.size + left.nuisances.size + smaller.kind.count)
    return _moved(problem, at, nowhere, _heard(problem, larger, smaller.kind))


def _heard(problem: Problem, row: Fitted, kind: Kind) -> list[Array]:
    """[SI] What the noise that a row hears makes of its signals, by segment."""
    quiet = problem.values(_played(problem, row, kind, np.zeros(kind.count)))
    return [own - still for own, still in zip(row.values, quiet, strict=True)]


def played_without(
    problem: Problem,
    whitening: Whitening,
    at: WithUnknown,
    size: float,
    left_out: Collection[int],
) -> list[Simulated] | None:
    """The recordings simulated with a free function that some of them have no part in.

    What the others ask for is one linear step away from the values that all of them gave. None
    where the twin cannot be simulated there.

    Parameters
    ----------
    problem : Problem
        Recordings and simulators.
    whitening : Whitening
        By noise, under which it was fitted.
    at : WithUnknown
        Fitted to all.
    size : float
        [FMU's unit of the torque port] Standard deviation of the amplitudes.
    left_out : collection of int
        Recordings that have no part.
    """
    if left_out:
        own = at.left.beside_own_parts(whitening)
        matrix = np.diag(np.concatenate([at.left.curvatures, np.full(at.kind.count, size**-2)]))
        slope = -np.concatenate([at.left.slopes, at.amplitudes / size**2])
        for segment, z, j in zip(
            problem.segments, own(at.left.residual), at.blocks(own), strict=True
        ):
            if segment.record not in left_out:
                matrix, slope = matrix + j @ j.T, slope + j @ z.ravel()
        moved = _moved(
            problem, _without_own(at, left_out), _step(matrix, slope, _longest_steps(at)), ()
        )
        if moved is None:
            return None
        at = moved
    return _played(problem, at.left, at.kind, at.amplitudes)


def _without_own(at: WithUnknown, records: Collection[int]) -> WithUnknown:
    """The same without own parts of some recordings, which were read of them."""
    if not at.left.own.size:
        return at
    common = at.left.own.copy()
    common[list(records)] = 0.0
    return replace(at, left=replace(at.left, own=common))


def _longest_steps(at: WithUnknown) -> tuple[Array, Array]:
    """Least and largest step of each quantity: within its bounds, and where it is about linear."""
    row, free = at.left, np.full(len(at.amplitudes), np.inf)
    ends = bounds_of(row.priors)
    margin = 1e-6 * (ends[:, 1] - ends[:, 0])
    most = np.where([q.logarithmic for q in row.priors], LONGEST_STEP, np.inf)
    low = np.maximum(np.minimum(ends[:, 0] + margin - row.u, 0.0), -most)
    high = np.minimum(np.maximum(ends[:, 1] - margin - row.u, 0.0), most)
    bent = np.where(row.one_sided, LONGEST_STEP, np.inf)
    least = np.where(row.one_sided, -np.minimum(row.nuisances, LONGEST_STEP), -np.inf)
    return np.concatenate([low, least, -free]), np.concatenate([high, bent, free])


def _step(matrix: Array, slope: Array, ends: tuple[Array, Array]) -> Array:
    """Step that gains most of a parabola within some ends, shape (n,)."""
    factor = np.linalg.cholesky(matrix)
    aim = np.linalg.solve(factor, slope)
    low, high = ends
    wide = np.where(high > low, high, low + 1e-12)
    found: Array = lsq_linear(factor.T, aim, (low, wide), method="bvls").x
    return found


def _cost(whitening: Whitening, at: WithUnknown, size: float) -> float:
    """[nats] Negative log density of the recordings, the values and the amplitudes."""
    square = whitening.square(at.left.residual) + float(at.amplitudes @ at.amplitudes) / size**2
    return 0.5 * square - at.left.log_prior


def _moved(
    problem: Problem, at: WithUnknown, step: Array, heard: Sequence[Array]
) -> WithUnknown | None:
    """The row after a step; None where it cannot be simulated."""
    row = at.left
    p, q = row.u.size, row.u.size + row.nuisances.size
    nuisances = row.nuisances + step[p:q]
    nuisances[row.one_sided] = np.maximum(nuisances[row.one_sided], 0.0)
    moved = replace(row, u=row.u + step[:p], nuisances=nuisances)
    amplitudes = at.amplitudes + step[q:]
    runs = _played(problem, moved, at.kind, amplitudes)
    if not all(run.finite for run in runs):
        return None
    values = problem.values(runs)
    if heard:
        values = [own + more for own, more in zip(values, heard, strict=True)]
    if problem.has_run_away(values):
        return None
    own = problem.residual(values, nuisances)
    residual = without_own_parts(problem, own, row.columns, row.own)
    left = replace(moved, runs=runs, values=values, residual=residual)
    return replace(at, left=left, amplitudes=amplitudes)


def _played(problem: Problem, row: Fitted, kind: Kind, amplitudes: Array) -> list[Simulated]:
    point = problem.point(row.hypothesis, row.x, row.own_values)
    simulations = problem.simulations

    def one(record: int) -> Simulated:
        pushed = {kind.port: amplitudes @ kind.signals[record]}
        return simulations.run_one(point, record, excitation=pushed, acts_at_rest=True)

    return simulations.map(one, range(len(simulations.records)))
