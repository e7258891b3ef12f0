"""Points at which a hypothesis is simulated, and differences of its responses about them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.heard_noise import HeardNoise
from gmfbo.diagnosis.comparison.priors import (
    coordinates_of,
    inside,
    own_values,
    priors_of,
    values_at,
)
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.fitting.difference_steps import (
    Judge,
    bent_shares,
    with_finer_steps,
    with_judged_steps,
)
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.runs.simulated import Point

Array = NDArray[np.float64]
Square = Callable[[Sequence[Array]], float]
"""Whitened square of signals, by segment."""


class TrialPoints:
    """Simulations of one hypothesis in the coordinates of its priors.

    Parameters
    ----------
    problem : Problem
        Recordings and simulators.
    hypothesis : Hypothesis
        Its free quantities.
    freed : sequence of str
        Those of its parameters that the twin file holds fixed.
    heard : HeardNoise, optional
        Under which the recordings are simulated.

    Attributes
    ----------
    hypothesis : Hypothesis
        With difference steps as they were judged so far.
    priors : tuple of Prior
        Of its p free quantities.
    """

    def __init__(
        self,
        problem: Problem,
        hypothesis: Hypothesis,
        freed: Sequence[str] = (),
        heard: HeardNoise | None = None,
    ) -> None:
        self._problem, self._freed, self._heard = problem, tuple(freed), heard
        self.hypothesis, self.priors = hypothesis, priors_of(hypothesis, freed)

    def start(self, parameters: dict[str, float]) -> Array:
        """Coordinates of the hypothesis' own values and these of the twin, inside their ranges."""
        return inside(self.priors, coordinates_of(self.priors, self.hypothesis.start(parameters)))

    def at(self, u: Array, nuisances: Array | None, own: Array) -> Fitted | None:
        """What the hypothesis leaves there, without columns; None where a simulation runs away.

        Parameters
        ----------
        u : ndarray, shape (p,)
            Coordinates.
        nuisances : ndarray, shape (q,), optional
            [standard deviations]
        own : ndarray, shape (n_recordings, p)
            Own part of each quantity in each recording.
        """
        problem = self._problem
        hypothesis = self.hypothesis.at(values_at(self.priors, u))
        runs = problem.simulations.run([self._point(u, own)])[0]
        if not all(run.finite for run in runs):
            return None
        if self._heard is not None:
            runs = self._heard.beside(problem, hypothesis, self._own_values(u, own), runs)
        nu = np.zeros(len(problem.nuisances)) if nuisances is None else nuisances
        values = problem.values(runs)
        if problem.has_run_away(values):
            return None
        residual = problem.residual(values, nu)
        return Fitted(
            hypothesis,
            self._freed,
            self.priors,
            u,
            nu,
            runs,
            values,
            residual,
            [],
            False,
            problem.logging.one_sided,
            own,
            self._heard,
        )

    def aside(self, at: Fitted) -> Array:
        """Coordinate of each free quantity after its difference step, shape (p,)."""
        sizes = self.hypothesis.difference_sizes(at.x)
        back = [p.logarithmic and v <= 0.0 for p, v in zip(self.priors, at.x + sizes, strict=True)]
        return coordinates_of(self.priors, at.x + np.where(back, -sizes, sizes))

    def columns(self, at: Fitted) -> list[Array]:
        """Differences: those of laws that meet noise about its point, all others without it.

        About that point the former are exact. Far from it they lack what the law makes there
        without noise, and a search takes more steps.
        """
        problem, aside = self._problem, self.aside(at)
        widths = aside - at.u
        moves, hears = [], [False] * widths.size
        still = noisy = problem.as_stored(at.values, at.nuisances)
        if self._heard is not None:
            about = problem.simulations.run([self._point(at.u, at.own), self._noisy(at.u, at.own)])
            still, noisy = (problem.as_stored(problem.values(r), at.nuisances) for r in about)
            if all(run.finite for run in about[1]):
                hears = self.hypothesis.bent
        for i, hears_it in enumerate(hears):
            u = np.where(np.arange(widths.size) == i, aside, at.u)
            moves.append(self._noisy(u, at.own) if hears_it else self._point(u, at.own))
        found = []
        played = problem.simulations.run(moves)
        for runs, width, hears_it in zip(played, widths, hears, strict=True):
            values = problem.values(runs)
            if all(run.finite for run in runs) and not problem.has_run_away(values):
                # What is stored late is late in each column too.
                stored = problem.as_stored(values, at.nuisances)
                change = zip(stored, noisy if hears_it else still, strict=True)
                found.append([(after - before) / width for after, before in change])
            else:
                found.append([np.zeros_like(v) for v in at.values])
        flat = (np.reshape([f[s] for f in found], (-1, *v.shape)) for s, v in enumerate(at.values))
        return self._beside_nuisances(at, list(flat))

    def renewed(self, at: Fitted, columns: list[Array]) -> list[Array]:
        """Columns that were measured nearby, with those of the logger as they are here."""
        count = len(self.priors)
        return self._beside_nuisances(at, [own[:count] for own in columns])

    def _beside_nuisances(self, at: Fitted, columns: list[Array]) -> list[Array]:
        own = self._problem.nuisance_columns(at.values, at.nuisances)
        return [np.concatenate(both) for both in zip(columns, own, strict=True)]

    def with_clear_steps(self, at: Fitted, square: Square) -> Fitted:
        """The same, with difference steps that an encoder's counts in the twin do not drown."""
        return self.with_judged_steps(at, square) if self.is_shuffled else at

    def with_judged_steps(self, at: Fitted, square: Square) -> Fitted:
        """The same, with a difference step of each quantity that has none yet."""
        self.hypothesis = with_judged_steps(self.hypothesis, at.x, self._judged(at, square))
        return self.restated(at)

    def restated(self, at: Fitted) -> Fitted:
        """The same, with the hypothesis' difference steps as they are by now."""
        return replace(at, hypothesis=self.hypothesis.at(at.x))

    def shorten_steps(self, at: Fitted, shown: dict[str, float], square: Square) -> bool:
        """Take shorter differences where a law bends within the usual ones; whether any is.

        Parameters
        ----------
        at : Fitted
            Where they are judged.
        shown : dict of str to float
            [standard deviations] By how much a step of each quantity to judge changes the signals.
        square : callable (sequence of ndarray) -> float
            Whitened square.
        """
        usual = self.hypothesis
        self.hypothesis = with_finer_steps(usual, at.x, shown, self._judged(at, square))
        return self.hypothesis is not usual

    @property
    def is_shuffled(self) -> bool:
        """Whether any small change lets the twin's counts fall otherwise."""
        return self._problem.is_counted or self.hypothesis.setting.is_rough

    def _judged(self, at: Fitted, square: Square) -> Judge:
        def judged(moves: Array) -> list[float | None]:
            there = [(move, coordinates_of(self.priors, at.x + move)) for move in moves]
            u = [np.where(move != 0.0, v, at.u) for move, v in there]
            played = self._problem.simulations.run([self._point(v, at.own) for v in u])
            seen = [self._problem.values(r) if all(q.finite for q in r) else None for r in played]
            return bent_shares(seen, square)

        return judged

    def _own_values(self, u: Array, own: Array) -> list[dict[str, float]]:
        return own_values(self.priors, self.hypothesis.names, u, own)

    def _point(self, u: Array, own: Array) -> Point:
        values = self._own_values(u, own)
        return self._problem.point(self.hypothesis, values_at(self.priors, u), values)

    def _noisy(self, u: Array, own: Array) -> Point:
        assert self._heard is not None
        hypothesis = self.hypothesis.at(values_at(self.priors, u))
        return self._heard.points(self._problem, hypothesis, self._own_values(u, own))[0]
