"""Latent torque: the torque at a port that would explain a residual, by deconvolution.

D = (G^H S^-1 G + 1/P)^-1 G^H S^-1 E, the Wiener estimate (Wiener 1949) of a signal with power P
seen through G in noise of covariance S. P is the residual's power beyond the noise at each
frequency, so that the estimate vanishes where the residual is noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.signal.windows import tukey

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.runs.scored_record import ScoredSignal
from gmfbo.diagnosis.scoring.whitening import Spectrum, Window
from gmfbo.diagnosis.screening.port_response import PortResponse

Array = NDArray[np.float64]

_CLOSURE = 0.15  # of the duration: joins the end of a residual to its beginning
_ANSWERED = 0.9  # of a kernel's energy
_SMOOTHED = 9  # bins over which power is averaged
_SIGNIFICANT = 2.0  # standard deviations of smoothed noise power that do not count as signal


@dataclass(frozen=True, eq=False)
class Latent:
    """Latent torque of one recording.

    Attributes
    ----------
    time : ndarray, shape (rows,)
        [s] Communication points.
    torque : ndarray, shape (rows,)
        [port's unit] From each communication point to the next; 0 outside the scored stretch.
    standard_error : ndarray, shape (rows,)
        [port's unit] From noise alone; infinite where nothing is scored or answered yet.
    """

    time: Array
    torque: Array
    standard_error: Array


def latent_torque(case: Case, base: Fitted, response: PortResponse) -> list[Latent]:
    """Deconvolve the residual of a fitted model in each recording.

    Parameters
    ----------
    case : Case
        With the covariances of the noise.
    base : Fitted
        The fitted model.
    response : PortResponse
        From the port to the signals.
    """
    return [_of_record(case, base, response, k) for k in range(len(response.rows))]


def _of_record(case: Case, base: Fitted, response: PortResponse, k: int) -> Latent:
    record = case.simulations.records[k]
    grid = record.plan.grid
    rows = np.flatnonzero((grid >= record.start - 1e-9) & (grid <= record.end + 1e-9))
    length = round((1.0 + _CLOSURE) * rows.size)
    top = max(float(w.frequencies[-1]) for w in case.budget.windows if w.record == k)
    frequencies = np.asarray(np.fft.rfftfreq(length, response.step), dtype=np.float64)
    bins = int(np.count_nonzero(frequencies <= top))
    frequencies = frequencies[:bins]
    residual = np.stack(
        [
            np.fft.rfft(_closed(_gridded(signal, values, grid[rows]), length))[:bins]
            for signal, values in zip(record.signals, base.simulated[k].signals, strict=True)
        ],
        axis=-1,
    )
    noise = _noise_power(case, k, frequencies) * rows.size
    seen = frequencies[:, None] <= 0.45 / np.array([s.spacing for s in record.signals])
    gains = response.gains(k, frequencies) * seen
    towards = np.einsum("fi,fij->fj", gains.conj(), np.linalg.inv(noise))
    information = np.real(np.einsum("fj,fj->f", towards, gains))
    information = np.maximum(information, 1e-12 * information.max())
    plain = np.einsum("fj,fj->f", towards, residual) / information
    wiener = _share_kept(np.abs(plain) ** 2, 1.0 / information)
    torque = np.zeros(grid.size)
    spectrum = np.zeros(length // 2 + 1, dtype=complex)
    spectrum[:bins] = wiener * plain
    torque[rows] = np.fft.irfft(spectrum, length)[: rows.size]
    variance = 2.0 * float(np.sum(wiener**2 / information)) / length**2
    error = np.full(grid.size, np.inf)
    # A torque just before the end has not yet reached the outputs.
    error[rows[: -_delay(response, k)]] = np.sqrt(variance)
    return Latent(grid, torque, error)


def _delay(response: PortResponse, k: int) -> int:
    """Steps until most of the answer to a push has come."""
    energies = [np.cumsum(kernel**2) / np.sum(kernel**2) for kernel in response.kernels[k]]
    return max(1, *(int(np.count_nonzero(energy < _ANSWERED)) for energy in energies))


def _gridded(signal: ScoredSignal, values: Array, grid: Array) -> Array:
    column: Array = np.interp(grid, signal.time, signal.values - values)
    return column


def _closed(column: Array, length: int) -> Array:
    """Join the end smoothly to the beginning, shape (length,), so that no jump acts as torque."""
    n = length - column.size
    way = 0.5 - 0.5 * np.cos(np.pi * np.arange(1, n + 1) / (n + 1))
    few = max(1, column.size // 200)
    first, last = float(np.mean(column[:few])), float(np.mean(column[-few:]))
    closed: Array = np.concatenate([column, last + (first - last) * way])
    return closed


def _noise_power(case: Case, k: int, frequencies: Array) -> Spectrum:
    """Mean variance of an unscaled discrete spectrum per sample, from the windows' covariances."""
    spectra = []
    step = float(np.diff(case.simulations.records[k].plan.grid[:2])[0])
    for window, covariance in zip(case.budget.windows, case.budget.covariances, strict=True):
        if window.record == k:
            spectra.append(_interpolated(window, covariance, frequencies, step))
    mean: Spectrum = np.mean(spectra, axis=0)
    return mean


def _interpolated(
    window: Window, covariance: Spectrum, frequencies: Array, step: float
) -> Spectrum:
    """Covariance per sample of the grid at other frequencies."""
    scales = []
    for rows in window.rows:
        n = rows.stop - rows.start
        spacing = 1.0 / (window.frequencies[1] * n)
        scales.append(n / np.sqrt(np.sum(tukey(n, 0.1) ** 2)) * np.sqrt(spacing / step))
    scaled = covariance * np.outer(scales, scales)
    diagonal = np.arange(scaled.shape[1])
    scaled[:, diagonal, diagonal] = np.maximum(np.real(scaled[:, diagonal, diagonal]), 1e-300)
    out = np.zeros((frequencies.size, *scaled.shape[1:]), dtype=complex)
    for i in diagonal:
        for j in diagonal:
            out[:, i, j] = np.interp(frequencies, window.frequencies, scaled[:, i, j].real) + (
                1j * np.interp(frequencies, window.frequencies, scaled[:, i, j].imag)
            )
    return out


def _share_kept(power: Array, noise: Array) -> Array:
    """Wiener gain P / (P + noise), where P is the smoothed power beyond the noise."""
    ratio = uniform_filter1d(power / noise, _SMOOTHED, mode="nearest")
    # Power of noise is exponential: a mean over n bins varies by 1/sqrt(n) of itself.
    beyond = ratio - 1.0
    beyond[beyond < _SIGNIFICANT / np.sqrt(_SMOOTHED)] = 0.0
    return beyond / (1.0 + beyond)
