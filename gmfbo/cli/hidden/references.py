"""References of the demo's recordings, the same for every draw."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SAMPLE_S = 1e-3
"""[s] Period of the controller and of the logger."""

DURATION_S = 2.5
"""[s] Duration of each recording."""

_QUIET_S = 0.1  # at zero, before the motion


def references() -> tuple[Array, ...]:
    """Return slow reversals, point-to-point moves, a sum of sines and a chirp.

    Returns
    -------
    tuple of ndarray, each of shape (2500,)
        [rad] Reference at each sample; they begin at zero, at rest.
    """
    time = SAMPLE_S * np.arange(round(DURATION_S / SAMPLE_S), dtype=np.float64)
    return _reversals(time), _moves(time), _sines(time), _chirp(time)


def _reversals(time: Array) -> Array:
    """Ramps of 3 rad/s between turning points, rounded over 60 ms."""
    corners = np.array([0.0, 1.2, -0.9, 0.5, -0.3, 0.0])
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(corners)))])
    wave = np.interp(3.0 * (time - _QUIET_S), travelled, corners)
    kernel = np.hanning(62)[1:-1]
    rounded = np.convolve(np.pad(wave, 60, mode="edge"), kernel / kernel.sum(), mode="same")
    return np.asarray(rounded[60:-60])


def _moves(time: Array) -> Array:
    """Moves of 0.28 s with least jerk (Flash and Hogan 1985), and pauses between them."""
    wave = np.zeros_like(time)
    for number, (begin, end) in enumerate(pairwise([0.0, 1.6, 0.2, -1.4, -0.4, 0.6])):
        s = np.clip((time - _QUIET_S - 0.45 * number) / 0.28, 0.0, 1.0)
        wave += (end - begin) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    return wave


def _sines(time: Array) -> Array:
    """Eight lines from 0.4 to 12 Hz, phases after Schroeder 1970."""
    lines = np.geomspace(0.4, 12.0, 8)
    sizes = 0.9 / (1.0 + (lines / 1.2) ** 1.6)
    phases = -np.pi * np.arange(8) * np.arange(1, 9) / 8.0
    angles = 2.0 * np.pi * lines[:, None] * time + phases[:, None]
    return np.asarray(_faded(time) * (sizes[:, None] * np.sin(angles)).sum(axis=0))


def _chirp(time: Array) -> Array:
    """Sweep from 0.6 to 14 Hz, its frequency growing by the same factor in the same time."""
    rate = np.log(14.0 / 0.6) / DURATION_S
    frequency = 0.6 * np.exp(rate * time)
    sweep = np.sin(2.0 * np.pi * (frequency - 0.6) / rate)
    return np.asarray(_faded(time) * sweep / (1.0 + (frequency / 2.5) ** 1.5))


def _faded(time: Array) -> Array:
    """Zero while quiet, then raised to one within 0.3 s."""
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.clip((time - _QUIET_S) / 0.3, 0.0, 1.0)))
