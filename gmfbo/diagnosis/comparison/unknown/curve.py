"""The curve of a free function over its state, and what it foretells."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.inadequacy import ends_of, motion_of
from gmfbo.diagnosis.comparison.numbers import MOST, UNLIKE
from gmfbo.diagnosis.comparison.priors import bounds_of
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.unknown.fitted import WithUnknown, played_without
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.fitting.intervals import TWO_SIDED
from gmfbo.diagnosis.runs.simulated import Simulated

Array = NDArray[np.float64]

_POINTS = 101  # of a drawn curve, at least
_A_BUMP = 2.5  # points, of what is finer
_HARDLY = 0.01  # of the rows of the middle bin: too few for a point


@dataclass(frozen=True, eq=False)
class DrawnFunction:
    """A function of one state, with its band by noise.

    Attributes
    ----------
    against : str
        The state or the time, and how the function acts with it.
    x : ndarray, shape (n,)
        [FMU's unit of the state] Rising.
    y : ndarray, shape (n,)
        [FMU's unit of the port] The function.
    half : ndarray, shape (n,)
        [FMU's unit of the port] Half of its 95 % band.
    """

    against: str
    x: Array
    y: Array
    half: Array


@dataclass(frozen=True, eq=False)
class FreeFunction:
    """A free function as it was fitted.

    Attributes
    ----------
    problem : Problem
        Recordings and simulators.
    whitening : Whitening
        By noise, under which it was fitted.
    fitted : WithUnknown
        With the row of laws beside it.
    size : float
        [FMU's unit of the torque port] Standard deviation of its amplitudes.
    """

    problem: Problem
    whitening: Whitening
    fitted: WithUnknown
    size: float

    def played(self, left_out: Collection[int]) -> list[Simulated] | None:
        """The recordings simulated with it, some of them without a part in its fit, or None.

        Parameters
        ----------
        left_out : collection of int
            Recordings that have no part.
        """
        return played_without(self.problem, self.whitening, self.fitted, self.size, left_out)

    def curve(self) -> DrawnFunction | None:
        """The function over its state, less what quantities of the row make as well.

        A function of more than that state is drawn as the curve that comes nearest to it, where
        that holds most of it; with the sign of a rate where that comes nearer.
        """
        kind, (values, covariance) = self.fitted.kind, self._apart_from_the_row()
        along, signals = self._along(), np.concatenate(kind.signals, axis=1)
        count = max(_POINTS, round(_A_BUMP * kind.count / len(kind.ways)))
        bins = _Bins.over(along, count, is_speed=kind.against == "velocity")
        nearest, shown = None, MOST * float(bins.sums((values @ signals) ** 2).sum())
        for words, factors in kind.ways:
            factor = np.concatenate(factors)
            squares = bins.sums(factor**2)
            held = squares > 0.0
            held &= squares > _HARDLY * np.median(squares[held] if held.any() else squares)
            turn = np.stack([bins.sums(factor * own)[held] for own in signals], axis=1)
            turn /= squares[held, None]
            x, y = bins.sums(factor**2 * along)[held] / squares[held], turn @ values
            if squares[held] @ y**2 <= shown:
                continue
            shown = float(squares[held] @ y**2)
            spread = np.sqrt(np.maximum(np.sum((turn @ covariance) * turn, axis=1), 0.0))
            nearest = DrawnFunction(f"{kind.against}{words}", x, y, TWO_SIDED * spread)
        return nearest

    def _along(self) -> Array:
        """The state in all recordings, as it is with the function."""
        if self.fitted.kind.against == "time":
            grids = [record.plan.grid for record in self.problem.simulations.records]
            return np.concatenate([grid - grid[0] for grid in grids])
        if self.fitted.kind.against == "command":
            return np.concatenate([run.response.states["command"] for run in self.fitted.left.runs])
        motion = motion_of(self.problem, self.fitted.left)
        is_speed = self.fitted.kind.against == "velocity"
        return np.concatenate(motion.velocities if is_speed else motion.positions)

    def _apart_from_the_row(self) -> tuple[Array, Array]:
        """Amplitudes and their covariance, without what quantities of the row make as well.

        A slope over the velocity is viscous friction: with that among the parameters, the
        recordings only tell the rest. A quantity at its bound makes no more.
        """
        left, amplitudes = self.fitted.left, self.fitted.amplitudes
        flat = self.fitted.blocks(left.beside_own_parts(self.whitening))
        gram = sum((j @ j.T for j in flat), np.zeros((len(flat[0]), len(flat[0]))))
        p, q = left.u.size, left.curvatures.size
        prior = np.concatenate([left.curvatures, np.full(amplitudes.size, self.size**-2)])
        inverse: Array = np.linalg.inv(gram + np.diag(prior)).astype(np.float64)
        covariance = inverse[q:, q:]
        weights = gram[q:, q:] + np.diag(prior[q:])
        made = np.linalg.solve(weights, gram[q:, :p])
        size = np.diag(gram)[:p]
        unlike = size - np.einsum("np,np->p", gram[q:, :p], made)
        low, high = bounds_of(left.priors).T
        moves = np.minimum(left.u - low, high - left.u) > 1e-3 * (high - low)
        alike = made[:, (unlike < UNLIKE * size) & moves]
        if not alike.shape[1]:
            return amplitudes, covariance
        onto = np.linalg.lstsq(alike.T @ weights @ alike, alike.T @ weights, rcond=None)[0]
        rest = np.eye(amplitudes.size) - alike @ onto
        return rest @ amplitudes, rest @ covariance @ rest.T


@dataclass(frozen=True, eq=False)
class _Bins:
    """Bins over the range of a state, which is their number: finer about standstill."""

    place: NDArray[np.intp]
    inside: NDArray[np.bool_]
    count: int

    @classmethod
    def over(cls, along: Array, count: int, *, is_speed: bool) -> _Bins:
        """Bins over a state, without the few rows beyond its usual range."""
        ends = np.array(ends_of([along]))
        if is_speed:
            along, ends = (np.sign(v) * np.sqrt(np.abs(v)) for v in (along, ends))
        inside = (along >= ends[0]) & (along <= ends[1])
        edges = np.linspace(ends[0], ends[1], count + 1)[1:-1]
        return cls(np.searchsorted(edges, along[inside], side="right"), inside, count)

    def sums(self, values: Array) -> Array:
        """Sum of values over the rows of each bin, shape (n_bins,)."""
        found: Array = np.bincount(self.place, values[self.inside], self.count).astype(np.float64)
        return found
