"""Samples of the corrected twin (IS3) around a point that the axis ran.

Algorithm 1 of the publication: draw k' ~ N(k, (0.05 range)^2), run the twin at k', correct its
trajectory, and accept it if the correction is certain, sigma_c << alpha, with
sigma_c = sqrt(mean posterior variance over the samples) and alpha the root mean square of the
reference. The publication gives no number for "<<", and its loop may never end. Here a draw is
accepted at sigma_c <= 0.05 alpha, and there are at most 20 draws. Each rejected draw brings the
next one nearer to k, where the correction was trained, and fewer samples are a valid result::

    samples = draw_local_samples(point (d,), simulate, correction, alpha, SamplingSettings(), rng)
    samples.draws, samples.accepted       # LocalSample: point, time, simulated, corrected, ...
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gmfbo.correction.trajectory_gp import TrajectoryCorrection
from gmfbo.errors import InputError
from gmfbo.space import folded

Simulate = Callable[[NDArray[np.float64]], tuple[NDArray[np.float64], NDArray[np.float64]] | None]


@dataclass(frozen=True)
class SamplingSettings:
    """Settings of the draws; the defaults are the publication's where it states them.

    Attributes
    ----------
    count : int
        n_c, samples wanted.
    spread : float
        Standard deviation as a share of the range of each gain.
    at_border : {"project", "reflect"}
        Treatment of a draw outside the box; projection accumulates samples on its faces.
    tolerance : float
        Accept at sigma_c <= tolerance * alpha.
    most_draws : int
        Largest number of draws; fewer samples are then accepted.
    shrink : float
        Factor on the spread after each rejected draw.
    """

    count: int = 4
    spread: float = 0.05
    at_border: Literal["project", "reflect"] = "project"
    tolerance: float = 0.05
    most_draws: int = 20
    shrink: float = 0.8


@dataclass(frozen=True, eq=False)
class LocalSample:
    """One draw: its point, the twin's trajectory and the corrected one.

    Attributes
    ----------
    point : ndarray, shape (d,)
        Gains in the unit cube.
    time : ndarray, shape (n,)
        [s]
    simulated, corrected, std : ndarray, shape (n,)
        [signal] Twin, posterior mean and posterior standard deviation of the correction.
    sigma_c : float
        [signal] Root mean posterior variance.
    accepted : bool
        Whether it is certain enough to be used.
    """

    point: NDArray[np.float64]
    time: NDArray[np.float64]
    simulated: NDArray[np.float64]
    corrected: NDArray[np.float64]
    std: NDArray[np.float64]
    sigma_c: float
    accepted: bool


@dataclass(frozen=True)
class LocalSamples:
    """All draws around one point, in the order in which they were made."""

    draws: tuple[LocalSample, ...]
    failed: int = 0
    """Draws whose simulation failed; they have no trajectory."""

    @property
    def accepted(self) -> tuple[LocalSample, ...]:
        """Draws that may be used, at most as many as the settings ask for."""
        return tuple(draw for draw in self.draws if draw.accepted)


def reference_size(reference: ArrayLike) -> float:
    """Root mean square alpha of the reference over its samples [signal].

    The publication divides a sum over samples by a time; this is the plain mean.
    """
    values = np.asarray(reference, dtype=float)
    return float(np.sqrt(np.mean(values[np.isfinite(values)] ** 2)))


def into_box(point: NDArray[np.float64], at_border: str) -> NDArray[np.float64]:
    """Bring a point of shape (d,) into the unit cube, by projection or by reflection."""
    return np.clip(point, 0.0, 1.0) if at_border == "project" else folded(point)


def draw_local_samples(
    point: ArrayLike,
    simulate: Simulate,
    correction: TrajectoryCorrection,
    alpha: float,
    settings: SamplingSettings,
    rng: np.random.Generator,
) -> LocalSamples:
    """Draw, simulate and correct until enough samples are accepted.

    Parameters
    ----------
    point : array_like, shape (d,)
        k, gains of the real run in the unit cube.
    simulate : callable
        Takes gains of shape (d,) in the unit cube, returns time [s] and the twin's signal, each
        of shape (n,), or None where the simulation failed.
    correction : TrajectoryCorrection
        Trained on the run of the axis at `point`.
    alpha : float
        [signal] See `reference_size`.
    settings : SamplingSettings
        Settings of the draws.
    rng : numpy.random.Generator
        The only source of randomness.

    Raises
    ------
    InputError
        `point` is outside the unit cube, or `alpha` is not positive.
    """
    centre = np.asarray(point, dtype=float)
    if np.any(centre < 0.0) or np.any(centre > 1.0):
        raise InputError(f"expected a point in the unit cube, got {centre.tolist()}")
    if not alpha > 0.0:
        raise InputError(f"expected a positive size of the reference, got {alpha}")
    draws: list[LocalSample] = []
    spread, accepted, failed = settings.spread, 0, 0
    for _ in range(settings.most_draws):
        if accepted == settings.count:
            break
        place = into_box(centre + rng.normal(0.0, spread, centre.shape), settings.at_border)
        outcome = simulate(place)
        if outcome is None:
            failed += 1
            spread *= settings.shrink
            continue
        time, simulated = outcome
        corrected, std = correction.correct(time, simulated, place)
        sigma_c = float(np.sqrt(np.mean(std**2)))
        good = sigma_c <= settings.tolerance * alpha
        draws.append(LocalSample(place, time, simulated, corrected, std, sigma_c, good))
        accepted += good
        spread *= 1.0 if good else settings.shrink
    return LocalSamples(tuple(draws), failed)
