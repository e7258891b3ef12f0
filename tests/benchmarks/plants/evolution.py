"""CMA-ES within the unit cube (Hansen 2016, The CMA evolution strategy: a tutorial)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def cma_es(
    cost: Callable[[Vector], float],
    start: Vector,
    *,
    spread: float = 0.05,
    generations: int = 40,
    seed: int = 0,
) -> Vector:
    """The best point found, shape (d,); never worse than the start.

    Rank-mu and rank-one updates with the tutorial's weights and rates. Points outside the cube are
    brought to its faces before they are weighed; infinite costs rank last.

    Parameters
    ----------
    cost : callable
        Of a point of the unit cube, to be minimised.
    start : ndarray, shape (d,)
        First mean.
    spread : float
        First standard deviation.
    generations, seed : int
        How long, and which draws.
    """
    rng, d = np.random.default_rng(seed), len(start)
    count = 4 + int(3 * np.log(d))
    parents = count // 2
    raw = np.log((count + 1) / 2) - np.log(np.arange(1, parents + 1))
    weights = raw / raw.sum()
    effective = 1.0 / float((weights**2).sum())
    c_sigma = (effective + 2) / (d + effective + 5)
    d_sigma = 1 + 2 * max(0.0, np.sqrt((effective - 1) / (d + 1)) - 1) + c_sigma
    c_path = (4 + effective / d) / (d + 4 + 2 * effective / d)
    c_one = 2 / ((d + 1.3) ** 2 + effective)
    c_mu = min(1 - c_one, 2 * (effective - 2 + 1 / effective) / ((d + 2) ** 2 + effective))
    usual = np.sqrt(d) * (1 - 1 / (4 * d) + 1 / (21 * d * d))
    mean, sigma, shape = np.array(start, dtype=float), spread, np.eye(d)
    path_sigma, path = np.zeros(d), np.zeros(d)
    best, least = mean.copy(), cost(mean)
    for generation in range(generations):
        values, axes = np.linalg.eigh(shape)
        scales = np.sqrt(np.maximum(values, 1e-20))
        drawn = (axes * scales) @ rng.standard_normal((d, count))
        points = np.clip(mean + sigma * drawn.T, 0.0, 1.0)
        costs = np.array([cost(point) for point in points])
        order = np.argsort(costs, kind="stable")[:parents]
        if costs[order[0]] < least:
            best, least = points[order[0]].copy(), float(costs[order[0]])
        steps = (points[order] - mean) / sigma
        move = weights @ steps
        mean = mean + sigma * move
        whitened = axes @ ((axes.T @ move) / scales)
        path_sigma = (1 - c_sigma) * path_sigma
        path_sigma = path_sigma + np.sqrt(c_sigma * (2 - c_sigma) * effective) * whitened
        length = float(np.linalg.norm(path_sigma))
        stalls = length / np.sqrt(1 - (1 - c_sigma) ** (2 * (generation + 1))) / usual
        on = float(stalls < 1.4 + 2 / (d + 1))
        path = (1 - c_path) * path + on * np.sqrt(c_path * (2 - c_path) * effective) * move
        shape = (1 - c_one - c_mu) * shape + c_one * np.outer(path, path)
        shape = shape + c_mu * (steps.T * weights) @ steps
        sigma *= float(np.exp(min(1.0, c_sigma / d_sigma * (length / usual - 1))))
        if sigma * scales.max() < 1e-5:
            break
    return best
