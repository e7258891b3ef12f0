"""Fit a plant of low order to real runs, in the closed loop that they were made in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from gmfbo.tuning.methods.low_order.closed_loop import PlantModel, simulate
from gmfbo.tuning.methods.low_order.control_law import ControlLaw
from gmfbo.tuning.methods.low_order.runs import SampledRuns

Vector = NDArray[np.float64]

NAMES = ("gain", "damping", "stiffness", "coulomb", "offset", "delay")

STRUCTURES = (
    ("gain", "damping", "delay"),
    ("gain", "damping", "delay", "coulomb", "offset"),
    ("gain", "damping", "delay", "stiffness"),
    ("gain", "damping", "delay", "stiffness", "coulomb", "offset"),
)
"""What is free in each structure that is tried; what is not is zero."""

MOST_DELAY = 0.1
"""Longest delay, as a share of the run."""

STEPS, TRIED_STEPS = 12, 4
"""Steps of Levenberg and Marquardt (1963), and damping factors that are tried at once in each."""


@dataclass(frozen=True, eq=False)
class Identified:
    """A fitted plant.

    Attributes
    ----------
    plant : PlantModel
        One plant.
    names : tuple of str
        What was free.
    rms : float
        RMS error of the simulated measurement [unit of the signal].
    score : float
        Bayesian information criterion (Schwarz 1978), less is better.
    """

    plant: PlantModel
    names: tuple[str, ...]
    rms: float
    score: float


def identify(law: ControlLaw, runs: SampledRuns) -> Identified:
    """The plant of the structure that explains real runs best for its number of parameters.

    Parameters
    ----------
    law : ControlLaw
        Controller of the runs.
    runs : SampledRuns
        Real runs.
    """
    start = _open_loop_start(runs)
    # A short run beside its noise has few independent samples: a tenth are counted.
    count = max(runs.measured.size / 10.0, 2.0)
    found = []
    for names in STRUCTURES:
        values, error = _fit(law, runs, names, start)
        variance = max(error**2, np.finfo(float).tiny)
        score = count * float(np.log(variance)) + len(names) * float(np.log(count))
        found.append(Identified(_plant(values, start)[0], names, error, score))
    return min(found, key=lambda one: one.score)


def _plant(table: Vector, start: Vector) -> tuple[PlantModel, int]:
    """Plants of scaled values, shape (L, 6) or (6,): a value of one is that of the start."""
    rows = np.atleast_2d(table)
    gain, damping = start[0] * np.exp(rows[:, 0]), start[1] * np.exp(np.clip(rows[:, 1], -30, 30))
    unit = abs(start[0]) * start[3]  # acceleration by the commands of a run
    stiffness = start[1] ** 2 * np.maximum(rows[:, 2], 0.0)
    coulomb, offset = unit * np.maximum(rows[:, 3], 0.0), unit * rows[:, 4]
    return PlantModel(
        gain, damping, stiffness, coulomb, offset, np.clip(rows[:, 5], 0.0, 1.0) * start[4]
    ), len(rows)


def _errors(law: ControlLaw, runs: SampledRuns, table: Vector, start: Vector) -> Vector:
    """Error of the measurement, shape (L, R n), of L plants in all runs."""
    plants, many = _plant(table, start)
    each = len(runs)
    begin = np.stack([runs.measured[:, 0], runs.command[:, 0]])
    y, _ = simulate(
        law,
        plants.repeated(each),
        np.tile(runs.gains, (many, 1)),
        np.tile(runs.reference, (many, 1)),
        np.tile(begin, (1, many)),
        runs.step,
    )
    return (y - np.tile(runs.measured, (many, 1))).reshape(many, -1)


def _fit(
    law: ControlLaw, runs: SampledRuns, names: tuple[str, ...], start: Vector
) -> tuple[Vector, float]:
    """Scaled values of a structure by Levenberg and Marquardt's method, and the RMS error."""
    free = np.array([NAMES.index(name) for name in names])
    values = np.zeros(len(NAMES))
    values[2] = 0.1 if "stiffness" in names else 0.0
    values[3] = 0.05 if "coulomb" in names else 0.0
    values[5] = start[5]
    error = _errors(law, runs, values, start)[0]
    least, weight, delta = float(error @ error), 1e-2, 1e-4
    for _ in range(STEPS):
        table = np.tile(values, (len(free), 1))
        table[np.arange(len(free)), free] += delta
        slopes = (_errors(law, runs, table, start) - error) / delta
        normal, downhill = slopes @ slopes.T, slopes @ error
        tried = np.tile(values, (TRIED_STEPS, 1))
        for row in range(TRIED_STEPS):
            damped = normal + weight * 10.0 ** (2 * row - 2) * np.diag(np.diag(normal) + 1e-300)
            tried[row, free] -= np.clip(np.linalg.pinv(damped) @ downhill, -2.0, 2.0)
        tried[:, 2:4] = np.maximum(tried[:, 2:4], 0.0)
        tried[:, 5] = np.clip(tried[:, 5], 0.0, 1.0)
        errors = _errors(law, runs, tried, start)
        costs = np.einsum("lm,lm->l", errors, errors)
        best = int(np.argmin(costs))
        if not costs[best] < least * (1.0 - 1e-6):
            break
        weight = float(np.clip(weight * 10.0 ** (2 * best - 2), 1e-9, 1e6))
        values, error, least = tried[best], errors[best], float(costs[best])
    return values, float(np.sqrt(least / error.size))


def _open_loop_start(runs: SampledRuns) -> Vector:
    """Gain, damping, stiffness, size of the command, longest delay, and share of it, to start from.

    For each of many dampings and delays the measurement is the response to the recorded command
    times a gain, beside the response to a constant force: the best of them by least squares.
    """
    step, count = runs.step, runs.time.size
    longest = MOST_DELAY * step * count
    size = float(np.max(np.abs(runs.command - runs.command[:, :1]))) or 1.0
    pushed = runs.command - runs.command[:, :1]
    moved = runs.measured - runs.measured[:, :1]
    best = (np.inf, 1.0, 1.0 / (step * count), 0.0)
    for damping in np.geomspace(0.3 / (step * count), 0.3 / step, 14):
        decay = float(np.exp(-damping * step))
        reach = (1.0 - decay) / damping
        for share in (0.0, 0.03, 0.1, 0.3, 0.6):
            late = round(share * longest / step)
            delayed = np.concatenate([np.zeros((len(runs), late)), pushed], axis=1)[:, :count]
            columns = []
            for force in (delayed, np.ones_like(delayed)):
                velocity = lfilter([reach], [1.0, -decay], force, axis=1)
                columns.append(np.cumsum(step * velocity, axis=1).ravel())
            table = np.column_stack(columns)
            found, *_ = np.linalg.lstsq(table, moved.ravel(), rcond=None)
            error = float(np.sum((table @ found - moved.ravel()) ** 2))
            if error < best[0] and found[0] != 0.0:
                best = (error, float(found[0]), damping, share)
    return np.array([best[1], best[2], 0.0, size, longest, best[3]])
