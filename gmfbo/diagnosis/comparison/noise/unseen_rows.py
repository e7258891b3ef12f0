"""Rows that nobody recorded: what a stationary process did before and after a recording.

Noise acts before a recording begins and after it ends. A filter that takes zeros for it would see
an integrator jump at both ends, and go on seeing it for as long as that integrator remembers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft
from scipy.linalg import cho_factor, cho_solve

Array = NDArray[np.float64]
Spectrum = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class UnseenRows:
    """The rows of a periodic process that were not seen, from those that were.

    Attributes
    ----------
    precision : ndarray, shape (n_frequencies, m, m)
        Inverse covariance of the m signals at each frequency.
    length : int
        [rows] Of the period.
    seen : int
        First rows of it, which are known.
    factor : tuple of (ndarray, bool)
        Cholesky factor of the precision of the others, as SciPy has it.
    """

    precision: Spectrum
    length: int
    seen: int
    factor: tuple[Array, bool]

    @classmethod
    def of(cls, covariance: Spectrum, length: int, seen: int) -> UnseenRows:
        """Prepare for a covariance.

        Parameters
        ----------
        covariance : ndarray, shape (n_frequencies, m, m)
            Of the signals' spectra.
        length : int
            [rows] Of the period.
        seen : int
            First rows of it, which are known.
        """
        precision = np.linalg.inv(covariance).astype(np.complex128)
        m, rows = precision.shape[1], length - seen
        lagged = irfft(precision, length, axis=0)
        apart = (np.arange(rows)[:, None] - np.arange(rows)) % length
        own = lagged[apart].transpose(2, 0, 3, 1).reshape(m * rows, m * rows)
        return cls(precision, length, seen, cho_factor(0.5 * (own + own.T), lower=True))

    def whole(self, columns: Array) -> Spectrum:
        """Spectra of signals with their unseen rows at the conditional mean.

        Given a normal process these minimise what whitening leaves (Rue and Held 2005, eq. 2.14).

        Parameters
        ----------
        columns : ndarray, shape (..., m, n)
            Signals in the rows that were seen.

        Returns
        -------
        ndarray, shape (..., m, n_frequencies)
        """
        spectrum = rfft(columns, self.length, axis=-1)
        beyond = irfft(mixed(self.precision, spectrum), self.length, axis=-1)[..., self.seen :]
        flat = beyond.reshape(-1, beyond.shape[-2] * beyond.shape[-1])
        made = np.zeros((*columns.shape[:-1], self.length))
        made[..., self.seen :] = -cho_solve(self.factor, flat.T).T.reshape(beyond.shape)
        both: Spectrum = spectrum + rfft(made, axis=-1)
        return both


def mixed(matrices: Spectrum, spectra: Spectrum) -> Spectrum:
    """A matrix of each frequency, (n, m, m), times the spectra of signals, (..., m, n).

    Row by row, without entries that are zero at all frequencies: with the few signals that there
    are, einsum takes three times as long.
    """
    out = np.empty_like(spectra)
    for i in range(spectra.shape[-2]):
        first, *others = np.flatnonzero(matrices[:, i].any(axis=0))
        row = matrices[:, i, first] * spectra[..., first, :]
        for j in others:
            row += matrices[:, i, j] * spectra[..., j, :]
        out[..., i, :] = row
    return out
