"""What noise that the controller read makes of simulated recordings, beyond its linear answer.

Noise overcomes small friction and bridges small gaps. A loop without them answers it linearly, and
that answer is in the covariance of the noise, whatever the parameters are: a parameter that changed
the answer would be fitted to noise (a filter time was named for it: development draw, 000 and 038).
So noise is played about one point, and only laws that are not linear meet it there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.runs.simulated import PlayedNoise, Point, Simulated

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class HeardNoise:
    """Noise that the controller read, and the point about which it is played.

    Attributes
    ----------
    played : tuple of PlayedNoise
        By recording, with its linear answer about the point.
    about : Hypothesis
        Of the twin's parameters and linear effects.
    parameters : mapping of str to float
        [FMU's unit] Of the twin there.
    """

    played: tuple[PlayedNoise, ...]
    about: Hypothesis
    parameters: Mapping[str, float]

    def points(
        self, problem: Problem, hypothesis: Hypothesis, own: Sequence[Mapping[str, float]] = ()
    ) -> tuple[Point, Point]:
        """The point with the laws of a hypothesis that are not linear: under noise, and without.

        Parameters
        ----------
        problem : Problem
            Recordings and simulators.
        hypothesis : Hypothesis
            Its effects are at their values.
        own : sequence of mapping of str to float
            By recording, values of some of its quantities there.
        """
        laws = tuple(c for c in hypothesis.effects if not c.law.is_linear)
        # Two effects can't both take their load's inertia from the same axis.
        shared = any(c.law.inertia_share for c in laws)
        kept_on = (c for c in self.about.effects if not (shared and c.law.inertia_share))
        there = replace(self.about, effects=(*kept_on, *laws))
        names = {f"{c.effect}.{p.name}" for c in laws for p in c.parameters}
        kept = [{n: v for n, v in values.items() if n in names} for values in own]
        quiet = problem.point(there, there.start(self.parameters), kept)
        return replace(quiet, noise=self.played), quiet

    def beside(
        self,
        problem: Problem,
        hypothesis: Hypothesis,
        own: Sequence[Mapping[str, float]],
        runs: Sequence[Simulated],
    ) -> list[Simulated]:
        """Recordings simulated without noise, with what noise makes beyond its linear answer.

        They stay as they are where the point can't be simulated.

        Parameters
        ----------
        problem, hypothesis, own
            As of `points`.
        runs : sequence of Simulated
            The hypothesis without noise.
        """
        noisy, quiet = problem.simulations.run(self.points(problem, hypothesis, own))
        if not all(run.finite for run in (*noisy, *quiet)):
            return list(runs)
        return [_beside(*one) for one in zip(runs, noisy, quiet, strict=True)]

    def change_of(
        self,
        problem: Problem,
        hypothesis: Hypothesis,
        x: Array,
        own: Sequence[Mapping[str, float]],
        values: Sequence[Array],
    ) -> list[Array]:
        """[SI] By segment, by how much it changes simulated signals, shape (m, n).

        Parameters
        ----------
        problem, hypothesis, own
            As of `points`.
        x : ndarray, shape (p,)
            Values of the hypothesis' free quantities.
        values : sequence of ndarray, shape (m, n)
            [SI] Simulated signals, by segment.
        """
        quiet = problem.simulations.run([problem.point(hypothesis, x, own)])[0]
        runs = self.beside(problem, hypothesis, own, quiet)
        return [a - b for a, b in zip(problem.values(runs), values, strict=True)]


def _beside(run: Simulated, heard: Simulated, still: Simulated) -> Simulated:
    parts = zip(run.signals, heard.signals, still.signals, strict=True)
    return replace(run, signals=tuple(own + (after - before) for own, after, before in parts))
