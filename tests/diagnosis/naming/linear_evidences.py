"""Fits of linear models by hand: what each effect changes is a direction that a test chooses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis, Setting
from gmfbo.diagnosis.naming.decision import Evidence
from gmfbo.physics import CATALOGUE
from gmfbo.sources.twin.uncertain import Uncertain
from tests.physics.excitations import TYPICAL

Array = NDArray[np.float64]

ROWS = 150
"""Whitened residuals of each window."""

WINDOWS = 4
SETTING = Setting((Uncertain("inertia", 1.0, 0.5, 2.0),), TYPICAL)


def blocks(values: Array) -> tuple[Array, ...]:
    """Cut the last axis into windows."""
    return tuple(np.split(values, WINDOWS, axis=-1))


def direction(seed: int) -> Array:
    """Unit change of all windows' whitened residuals, shape (WINDOWS * ROWS,)."""
    drawn: Array = np.random.default_rng(seed).standard_normal(WINDOWS * ROWS)
    return drawn / np.linalg.norm(drawn)


def between(a: Array, b: Array, cosine: float) -> Array:
    """Unit direction in the plane of two others that is so near to the first."""
    apart = b - (a @ b) * a
    apart /= np.linalg.norm(apart)
    return np.asarray(cosine * a + np.sqrt(1.0 - cosine**2) * apart)


def fitted_of(residual: Array, effects: tuple[Candidate, ...] = (), own: int = 90) -> Fitted:
    """Model with one free parameter, which leaves this residual."""
    hypothesis = Hypothesis(SETTING, effects)
    sensitivity = blocks(20.0 * direction(own)[None])
    return Fitted(hypothesis, np.ones(1), [], blocks(residual), sensitivity, [])


def evidence_of(name: str, residual: Array, before: Array) -> Evidence:
    """One effect of the catalogue, which leaves this of what was there before."""
    start = CATALOGUE[name].starts(TYPICAL)[0]
    fitted = fitted_of(residual, (Candidate(name, dict(start)),))
    gains = np.array(
        [float(a @ a - b @ b) for a, b in zip(blocks(before), blocks(residual), strict=True)]
    )
    return Evidence(fitted, gains, np.abs(gains), float(residual @ residual))


@dataclass(frozen=True, eq=False)
class Fits:
    """One effect after the other fitted to the same residual.

    Attributes
    ----------
    base : Fitted
        Before any effect.
    effects : list of Evidence
        Best first.
    """

    base: Fitted
    effects: list[Evidence]

    def of(self, name: str) -> Evidence:
        """Evidence of an effect."""
        return next(e for e in self.effects if e.name == name)


def fits_of(residual: Array, changes: Mapping[str, Sequence[Array]]) -> Fits:
    """Fit each effect's directions to a residual by least squares.

    Parameters
    ----------
    residual : ndarray, shape (WINDOWS * ROWS,)
        What the twin without effects leaves.
    changes : mapping of str to sequences of ndarray, shape (WINDOWS * ROWS,)
        Directions of each effect.
    """
    effects = []
    for name, directions in changes.items():
        columns = np.array(directions).T
        size = np.linalg.lstsq(columns, residual, rcond=None)[0]
        effects.append(evidence_of(name, residual - columns @ size, residual))
    return Fits(fitted_of(residual), sorted(effects, key=lambda e: -e.gain))
