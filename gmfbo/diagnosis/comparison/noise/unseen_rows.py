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
class Mixing:
    """A matrix at each frequency, to multiply the spectra of m signals by.

    Entries that are zero at all frequencies are left out; with the few signals that there are,
    einsum takes three times as long.

    Attributes
    ----------
    rows : tuple of tuple of (int, ndarray), length m
        By signal that is made: which signals enter, each with its factor, shape (n_frequencies,).
    """

    rows: tuple[tuple[tuple[int, Spectrum], ...], ...]

    @classmethod
    def by(cls, matrices: Spectrum) -> Mixing:
        """Prepare for matrices, shape (n_frequencies, m, m)."""
        return cls(
            tuple(
                tuple((int(j), row[:, j].copy()) for j in np.flatnonzero(row.any(axis=0)))
                for row in np.moveaxis(matrices, 1, 0)
            )
        )

    def __call__(self, spectra: Spectrum) -> Spectrum:
        """The product, shape (..., m, n_frequencies) like the spectra."""
        out = np.empty_like(spectra)
        for i, ((first, factor), *others) in enumerate(self.rows):
            row = factor * spectra[..., first, :]
            for j, other in others:
                row += other * spectra[..., j, :]
            out[..., i, :] = row
        return out


@dataclass(frozen=True, eq=False)
class UnseenRows:
    """The rows of a periodic process that were not seen, from those that were.

    Attributes
    ----------
    precision : Mixing
        By the inverse covariance of the m signals at each frequency.
    length : int
        [rows] Of the period.
    seen : int
        First rows of it, which are known.
    factor : tuple of (ndarray, bool)
        Cholesky factor of the precision of the others, as SciPy has it.
    """

    precision: Mixing
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
        factor = cho_factor(0.5 * (own + own.T), lower=True)
        return cls(Mixing.by(precision), length, seen, factor)

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
        beyond = irfft(self.precision(spectrum), self.length, axis=-1)[..., self.seen :]
        flat = beyond.reshape(-1, beyond.shape[-2] * beyond.shape[-1])
        made = np.zeros((*columns.shape[:-1], self.length))
        made[..., self.seen :] = -cho_solve(self.factor, flat.T, check_finite=False).T.reshape(
            beyond.shape
        )
        both: Spectrum = spectrum + rfft(made, axis=-1)
        return both
