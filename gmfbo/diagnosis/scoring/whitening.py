"""Whiten residuals by the error budget, per frequency and for all signals jointly.

chi2 = sum |w|^2 with w = sqrt(2) chol(S)^-1 X is the Whittle likelihood (Whittle 1953) of a
residual with discrete spectrum X and covariance S.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.signal.windows import tukey

Spectrum = NDArray[np.complex128]

TOP_FREQUENCY = 200.0
"""[Hz] Above it, a drive's residual is noise and computing delays."""

_TAPERED = 0.1  # share of a window that rises and falls
_UNSEEN = 1e30  # variance of a signal beyond its own Nyquist frequency


@dataclass(frozen=True, eq=False)
class Window:
    """A stretch of a recording and the frequencies at which it is scored.

    Attributes
    ----------
    record : int
        Index of the recording.
    rows : tuple of slice
        Of each of its signals.
    frequencies : ndarray, shape (n_bins,)
        [Hz] From 0.
    seen : ndarray of bool, shape (n_bins, n_signals)
        Below a signal's own Nyquist frequency.
    """

    record: int
    rows: tuple[slice, ...]
    frequencies: NDArray[np.float64]
    seen: NDArray[np.bool_]

    @property
    def n_signals(self) -> int:
        """Signals that are scored jointly."""
        return len(self.rows)

    def spectra(self, columns: Sequence[NDArray[np.float64]]) -> Spectrum:
        """Tapered discrete spectra of each signal, shape (..., n_bins, n_signals).

        Parameters
        ----------
        columns : sequence of ndarray, shape (..., n_rows of that signal)
            One array a signal, over the whole recording.
        """
        spectra = []
        for column, rows in zip(columns, self.rows, strict=True):
            part = column[..., rows]
            n = part.shape[-1]
            bins = min(self.frequencies.size, n // 2 + 1)
            own = np.zeros((*part.shape[:-1], self.frequencies.size), dtype=np.complex128)
            own[..., :bins] = np.fft.rfft(part * _taper(n))[..., :bins] / n
            spectra.append(own)
        return np.stack(spectra, axis=-1) * self.seen

    def white(self, variances: Sequence[float]) -> NDArray[np.float64]:
        """Covariance of white noise of these variances, shape (n_signals,).

        Parameters
        ----------
        variances : sequence of float
            [unit of the signal squared]
        """
        gains = []
        for variance, rows in zip(variances, self.rows, strict=True):
            n = rows.stop - rows.start
            gains.append(variance * float(np.sum(_taper(n) ** 2)) / n**2)
        return np.array(gains)


@lru_cache(maxsize=64)
def _taper(n: int) -> NDArray[np.float64]:
    return np.asarray(tukey(n, _TAPERED))


def make_window(
    record: int, spacings: Sequence[float], rows: Sequence[slice], top: float = TOP_FREQUENCY
) -> Window:
    """Choose the frequencies of a stretch of a recording.

    Parameters
    ----------
    record : int
        Index of the recording.
    spacings : sequence of float
        [s] Sampling of each signal.
    rows : sequence of slice
        Of each signal; all cover the same time.
    top : float
        [Hz] Highest frequency that is scored.
    """
    duration = max((r.stop - r.start) * s for r, s in zip(rows, spacings, strict=True))
    highest = min(top, max(0.45 / spacing for spacing in spacings))
    frequencies = np.arange(int(highest * duration) + 1) / duration
    seen = frequencies[:, None] <= 0.45 / np.asarray(spacings)[None, :]
    return Window(record, tuple(rows), frequencies, seen)


@dataclass(frozen=True, eq=False)
class Whitener:
    """Whitens the residuals of one window, and removes nuisances as far as their priors allow.

    Attributes
    ----------
    window : Window
        Stretch that is scored.
    covariance : ndarray, shape (n_bins, n_signals, n_signals)
        S(f) of the window's spectra.
    nuisances : ndarray, shape (n_nuisances, n_residuals)
        Whitened directions, each one standard deviation of its prior long; empty at first.
    dispersion : ndarray, shape (n_bins, n_signals)
        Factor by which the variance of each whitened component exceeds the budget, at least 1.
    """

    window: Window
    covariance: Spectrum
    nuisances: NDArray[np.float64] | None = None
    dispersion: NDArray[np.float64] | None = field(default=None)

    @cached_property
    def _factor(self) -> Spectrum:
        s = np.array(self.covariance)
        hidden = ~self.window.seen
        for signal in range(s.shape[-1]):
            s[hidden[:, signal], signal, :] = 0.0
            s[hidden[:, signal], :, signal] = 0.0
            s[hidden[:, signal], signal, signal] = _UNSEEN
        factor: Spectrum = np.linalg.inv(np.linalg.cholesky(s)).astype(np.complex128)
        return factor

    @cached_property
    def _deflation(self) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        if self.nuisances is None or not len(self.nuisances):
            return None
        _, sizes, basis = np.linalg.svd(self.nuisances, full_matrices=False)
        return basis, 1.0 - 1.0 / np.sqrt(1.0 + sizes**2)

    @property
    def n_residuals(self) -> int:
        """Number of whitened residuals of the window."""
        return 2 * int(self.window.seen.sum()) - self.window.n_signals

    def colour(self, spectra: Spectrum) -> Spectrum:
        """Whitened components, shape (..., n_bins, n_signals), with nuisances still in them."""
        white: Spectrum = np.einsum("fij,...fj->...fi", self._factor, spectra)
        if self.dispersion is not None:
            white = white / np.sqrt(self.dispersion)
        return white

    def whiten(self, columns: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
        """Whitened residuals, shape (..., n_residuals), each of unit variance if S is right.

        Parameters
        ----------
        columns : sequence of ndarray, shape (..., n_rows of that signal)
            Residuals or sensitivities, one array a signal.
        """
        flat = self.flatten(self.colour(self.window.spectra(columns)))
        if self._deflation is None:
            return flat
        basis, shares = self._deflation
        return flat - ((flat @ basis.T) * shares) @ basis

    def flatten(self, white: Spectrum) -> NDArray[np.float64]:
        """Real and imaginary parts of whitened components, shape (..., n_residuals)."""
        seen = self.window.seen
        inner = white[..., 1:, :][..., seen[1:]]
        return np.concatenate(
            [white[..., 0, :].real, np.sqrt(2.0) * inner.real, np.sqrt(2.0) * inner.imag], axis=-1
        )

    def without(self, directions: Sequence[Sequence[NDArray[np.float64]]]) -> Whitener:
        """Whitener that removes these directions, as far as their priors allow.

        Parameters
        ----------
        directions : sequence of sequences of ndarray
            Each one standard deviation of a nuisance's prior, one array a signal.
        """
        plain = replace(self, nuisances=None)
        rows = [plain.whiten(direction) for direction in directions]
        return replace(self, nuisances=np.array(rows).reshape(len(rows), self.n_residuals))
