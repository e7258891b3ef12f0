"""Find the state that a latent signal follows: variance explained by means over its bins.

The score is the F ratio of an analysis of variance (Fisher 1925). Bins are filtered by the lag of
the observed signal, so that reversals stay aligned.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear, lfilter

from gmfbo.diagnosis.case.tracking import HOLDING_RAD_S, tracking_loop
from gmfbo.physics import States

_BINS = 10
_TIME_BINS = 8  # of each recording
_BLOCK_S = 0.01
_LEAST_RANK = 4  # so that a state with a single column must explain as much as any other

Column = NDArray[np.float64]


@dataclass(frozen=True)
class StateFit:
    """Score of a state that may explain a latent signal.

    Attributes
    ----------
    state : str
        `direction`, `velocity`, `speed`, `position`, `command`, `acceleration` or `time`.
    score : float
        F ratio.
    share : float
        Share of the variance that it explains.
    at : float
        Value of the state at the largest signal.
    """

    state: str
    score: float
    share: float
    at: float


def rank_states(
    latent: Sequence[Column], states: Sequence[States], *, observed: bool
) -> list[StateFit]:
    """Compare the states by how well they explain a latent signal, best first.

    Parameters
    ----------
    latent : sequence of ndarray, shape (rows,)
        One a recording; NaN where it is not known.
    states : sequence of States
        Of the same recordings.
    observed : bool
        Whether the signal is the effort of a tracking loop, which lags behind the torque.
    """
    target = np.concatenate(
        [_blocks(s, _known(c)[:, None])[:, 0] for s, c in zip(states, latent, strict=True)]
    )
    target = target - target.mean()
    total = float(target @ target)
    if total <= 0.0:
        return []
    fits = [
        _fit(name, columns, states, target, total, observed)
        for name, columns in _candidates(states).items()
        if np.ptp(np.concatenate(columns)) > 0.0
    ]
    return sorted(fits, key=lambda f: -f.score)


def _candidates(states: Sequence[States]) -> dict[str, list[Column]]:
    return {
        "direction": [s.direction for s in states],
        "velocity": [s.velocity for s in states],
        "speed": [np.abs(s.velocity) for s in states],
        "position": [s.position for s in states],
        "command": [s.command for s in states],
        "acceleration": [s.acceleration for s in states],
        "time": [s.time for s in states],
    }


def _fit(
    name: str,
    columns: Sequence[Column],
    states: Sequence[States],
    target: Column,
    total: float,
    observed: bool,
) -> StateFit:
    features, centres = _features(name, columns)
    rows = []
    for own, s in zip(features, states, strict=True):
        seen = _through_loop(own, s.step) if observed else own
        rows.append(_blocks(s, seen))
    matrix = np.concatenate(rows)
    matrix = matrix - matrix.mean(axis=0)
    sizes, _, rank, _ = np.linalg.lstsq(matrix, target, rcond=1e-8)
    left = float(np.sum((target - matrix @ sizes) ** 2))
    freedom = max(1, target.size - int(rank) - 1)
    ratio = ((total - left) / max(_LEAST_RANK, int(rank))) / max(left / freedom, 1e-300)
    largest = int(np.argmax(np.abs(sizes - np.median(sizes))))
    return StateFit(name, float(ratio), 1.0 - left / total, float(centres[largest]))


def _features(name: str, columns: Sequence[Column]) -> tuple[list[Column], Column]:
    """Bins of each recording, shape (rows, n), and the state value of each."""
    if name == "direction":
        return [column[:, None] for column in columns], np.array([0.0])
    if name == "time":
        return _time_features(columns)
    together = np.concatenate(columns)
    edges = np.unique(np.quantile(together, np.linspace(0.0, 1.0, _BINS + 1)))
    places = [np.clip(np.searchsorted(edges, c, "right") - 1, 0, edges.size - 2) for c in columns]
    features = [np.eye(edges.size - 1)[place] for place in places]
    return features, 0.5 * (edges[1:] + edges[:-1])


def _time_features(columns: Sequence[Column]) -> tuple[list[Column], Column]:
    """Bins over time, separate for each recording."""
    features, centres = [], []
    width = _TIME_BINS * len(columns)
    for k, time in enumerate(columns):
        place = np.minimum(np.arange(time.size) * _TIME_BINS // time.size, _TIME_BINS - 1)
        features.append(np.eye(width)[place + k * _TIME_BINS])
        centres += [float(np.median(time[place == i])) for i in range(_TIME_BINS)]
    return features, np.array(centres)


def _through_loop(columns: Column, step: float) -> Column:
    """Filter a torque as a tracking loop on unit inertia does: (kd s + kp)/(s^2 + kd s + kp)."""
    loop = tracking_loop(1.0, [], HOLDING_RAD_S).settings
    kp, kd = loop["tracking.kp"], loop["tracking.kd"]
    upper, lower = bilinear([kd, kp], [1.0, kd, kp], 1.0 / step)
    return np.asarray(lfilter(upper, lower, columns, axis=0), dtype=np.float64)


def _blocks(states: States, columns: Column) -> Column:
    rows = max(1, round(_BLOCK_S / states.step))
    count = len(columns) // rows
    return np.asarray(columns[: count * rows].reshape(count, rows, -1).mean(axis=1))


def _known(column: Column) -> Column:
    return np.where(np.isfinite(column), column, 0.0)
