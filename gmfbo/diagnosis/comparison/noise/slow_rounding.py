"""Rounding of a position that moves slowly, which is no white noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_HARMONICS = np.arange(1.0, 11.0)  # those beyond hold 6 % of the variance
_FAINT = 0.1  # of a harmonic that noise spreads: as good as gone


def slow_rounding(position: Array, count: float, dither: float) -> Array:
    """Errors by rounding that rows have alike, each of one standard deviation.

    A reading is off by what is left of the path to the next count. Where the count begins is not
    known: then the covariance of two rows d counts apart is `count**2 / 2 * B2(d % 1)`, with the
    second Bernoulli polynomial, and its Fourier series are these columns (Widrow and Kollar 2008,
    ch. 4 and 20). A harmonic that turns by more than half a turn a row is as good as white, and
    white noise before the rounding spreads each over its turn.

    Parameters
    ----------
    position : ndarray, shape (n,)
        [SI] Path of the axis, within a count: where counts change it is known best.
    count : float
        [SI] Quantum of the reading.
    dither : float
        [SI] Standard deviation of the white noise that was rounded with it.

    Returns
    -------
    ndarray, shape (k, n)
        [SI]
    """
    turns = position / count
    moved, found = np.abs(np.gradient(turns)), []
    for k in _HARMONICS:
        slow = k * moved < 0.5
        spread = np.exp(-2.0 * (np.pi * k * dither / count) ** 2)
        if spread > _FAINT and slow.any():
            size = slow * spread * count / (np.sqrt(2.0) * np.pi * k)
            turned = 2.0 * np.pi * k * turns
            found += [size * np.cos(turned), size * np.sin(turned)]
    return np.array(found).reshape(len(found), position.size)


def between_counts(position: Array) -> Array:
    """Straight from each change of a reading to the next, halfway between both, shape (n,).

    Parameters
    ----------
    position : ndarray, shape (n,)
        As it was read.
    """
    changes = np.flatnonzero(np.diff(position))
    if not changes.size:
        return position
    halfway = 0.5 * (position[changes] + position[changes + 1])
    return np.interp(np.arange(position.size), changes + 0.5, halfway)
