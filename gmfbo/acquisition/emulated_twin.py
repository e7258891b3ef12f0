"""Next run of the axis by the corrected twin, searched on an emulator of the twin.

The objective of a trajectory jumps, so its gradient is of no use: candidates cover the box, and
lie around the best of them. The twin is run once over the box (a survey), and interpolated
between these runs, so that a search costs no further simulation::

    emulator = emulate(survey_points (m, d), survey_trajectories (m, n))
    model = CorrectedTwinModel.fit(runs, cost_of)
    point, log_ei = next_axis_run(model, emulator, Search(dimension=2), rng)
    point, mean = expected_best(model, emulator, Search(dimension=2), rng)

On the drive twin with 50 % noise in its flux map, a survey of 150 runs and 22 seeds, the optimum
took 7.7 runs of the axis on average, initial ones counted, and 13 at most.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from gmfbo.acquisition.improvement import log_improvement
from gmfbo.acquisition.maximise import SAME_POINT, Search
from gmfbo.correction.residual_process import ResidualProcess
from gmfbo.errors import InputError
from gmfbo.surrogate.corrected_twin import CorrectedTwinModel, likeliest_lengthscale

Scores = Callable[[NDArray[np.float64]], NDArray[np.float64]]

COVERING, AROUND = 512, 240
# Points drawn beyond the box are put on its faces, where optima of gains often lie.
OVERHANG = 0.05
LEADERS = 5
# Standard deviations of the second round of candidates: from a tenth of the lengthscale of the
# objective's departure to a step that a controller's display still shows.
RADII = (0.06, 0.02, 0.007)


def emulate(points: NDArray[np.float64], trajectories: NDArray[np.float64]) -> ResidualProcess:
    """Process that interpolates the twin's trajectories, shape (m, n), over points (m, d)."""
    away = trajectories - trajectories.mean(axis=0)
    return ResidualProcess.fit(
        points, trajectories, lengthscale=likeliest_lengthscale(points, away), centred=True
    )


def next_axis_run(
    model: CorrectedTwinModel,
    emulator: ResidualProcess,
    search: Search,
    rng: np.random.Generator,
    incumbent: float | None = None,
) -> tuple[NDArray[np.float64], float]:
    """Gains in the unit cube, shape (d,), with the largest log EI of the axis, and that value.

    Parameters
    ----------
    model : CorrectedTwinModel
        Fitted to all runs of the axis.
    emulator : ResidualProcess
        See `emulate`.
    search : Search
        Fixed and snapped gains, limits, and where the axis must not be run.
    rng : numpy.random.Generator
        The only source of chance.
    incumbent : float, optional
        [g] Bar of an improvement, instead of the least observed.

    Raises
    ------
    InputError
        All candidates were run already.
    """
    bar = float(model.runs.values.min()) if incumbent is None else incumbent

    def score(points: NDArray[np.float64]) -> NDArray[np.float64]:
        mean, variance = model.predict(points, emulator.mean(points))
        return log_improvement(mean, variance, bar) + search.log_weights(points)

    points, values = _candidates(score, model, search, rng)
    apart = np.abs(points[:, None, :] - model.runs.points[None, :, :]).max(axis=2).min(axis=1)
    values = np.where(apart > SAME_POINT, values, -np.inf)
    best = int(np.argmax(values))
    if not np.isfinite(values[best]):
        raise InputError("all candidate gains were run already by IS1; widen the box or stop")
    return points[best], float(values[best])


def expected_best(
    model: CorrectedTwinModel,
    emulator: ResidualProcess,
    search: Search,
    rng: np.random.Generator,
) -> tuple[NDArray[np.float64], float]:
    """Gains with the least posterior mean of g, shape (d,), and that mean."""

    def score(points: NDArray[np.float64]) -> NDArray[np.float64]:
        improbable = search.log_weights(points) < np.log(0.5)
        return np.where(improbable, -np.inf, -model.predict(points, emulator.mean(points))[0])

    points, values = _candidates(score, model, search, rng)
    best = int(np.argmax(values))
    return points[best], -float(values[best])


def _candidates(
    score: Scores, model: CorrectedTwinModel, search: Search, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points that cover the box, then points around the best of them and the best run."""
    cover = qmc.Sobol(d=search.dimension, rng=rng).random(COVERING)
    points = _allowed(cover * (1.0 + 2.0 * OVERHANG) - OVERHANG, search)
    values = score(points)
    leaders = np.vstack(
        [
            points[np.argsort(-values, kind="stable")[:LEADERS]],
            model.runs.points[[int(np.argmin(model.runs.values))]],
        ]
    )
    centres = leaders[rng.integers(0, len(leaders), AROUND)]
    radii = rng.choice(RADII, (AROUND, 1))
    near = _allowed(centres + radii * rng.standard_normal(centres.shape), search)
    return np.vstack([points, near]), np.concatenate([values, score(near)])


def _allowed(points: NDArray[np.float64], search: Search) -> NDArray[np.float64]:
    inside = np.clip(points, 0.0, 1.0)
    for column, value in search.fixed.items():
        inside[:, column] = value
    return inside if search.snap is None else search.snap(inside)
