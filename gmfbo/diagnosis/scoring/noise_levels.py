"""Noise levels: how large a residual may be without missing physics, S(f) of each window.

S = loop noise + own noise of each signal + difference of repeats + tolerance. The control loop
colours the residual even of a perfect twin, so noise is sent through the loop.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from gmfbo.diagnosis.runs.scored_record import Record, ScoredSignal
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.scoring.whitening import Spectrum, Window

TOLERANCE = 5e-3
"""Negligible share of a signal (prototype: 0.5 % and floors, 0 of 16 false)."""

POSITION_TOLERANCE = 5e-4
"""Negligible share of a position, whose control error is about a hundredth of it."""

SECOND_DIFFERENCE = float(0.6745 * np.sqrt(6.0))
"""Median amount of a second difference of white noise, in its standard deviations."""

_LOWEST_HZ = 1.0  # below it, a tracking loop holds a free axis
_NOISE_BAND = (0.30, 0.48)  # of the sampling frequency: too fast for mechanics
_LEAST_NOISE = 1e-6  # of a signal's range


@dataclass(frozen=True)
class NoiseLevel:
    """White noise of one signal.

    Attributes
    ----------
    total : float
        [SI] Standard deviation, from the part of the signal that is too fast for mechanics.
    least : float
        [SI] What rounding to counts or a simulation's own errors cause, whichever is more.
    """

    total: float
    least: float


def noise_levels(
    records: Sequence[Record], simulated: Sequence[Simulated]
) -> list[dict[str, NoiseLevel]]:
    """Estimate each signal's noise from the fastest part of its residual, for each recording.

    Parameters
    ----------
    records : sequence of Record
        Recordings that are scored.
    simulated : sequence of Simulated
        The same recordings simulated; parameters matter little at these frequencies.
    """
    levels = []
    for record, run in zip(records, simulated, strict=True):
        own = {}
        for signal, values in zip(record.signals, run.signals, strict=True):
            own[signal.name] = noise_level(signal, signal.values - values)
        levels.append(own)
    return levels


def rounding_of(signal: ScoredSignal) -> float:
    """[SI] Standard deviation of a signal's rounding to its counts."""
    return float(signal.resolution / np.sqrt(12.0))


def noise_level(signal: ScoredSignal, residual: NDArray[np.float64]) -> NoiseLevel:
    """Noise of one signal.

    Parameters
    ----------
    signal : ScoredSignal
        As it was recorded.
    residual : ndarray, shape (n,)
        [SI] Part of the signal that is not motion.
    """
    # Of counts that are finer than that, a simulation's own errors are more.
    computed = _LEAST_NOISE * float(np.ptp(signal.values))
    least = max(rounding_of(signal), computed, 1e-15)
    return NoiseLevel(max(float(np.sqrt(fast_power(residual))), least), least)


def pooled(levels: Sequence[Mapping[str, NoiseLevel]], name: str) -> NoiseLevel | None:
    """Median of one signal's noise over the recordings; None where no recording has the signal."""
    own = [level[name] for level in levels if name in level]
    if not own:
        return None
    return NoiseLevel(
        float(np.median([level.total for level in own])),
        float(np.median([level.least for level in own])),
    )


def fast_power(residual: NDArray[np.float64]) -> float:
    """Variance of white noise with the same spectrum near the Nyquist frequency.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Part of the signal that is not motion.
    """
    return _level(_fast_bins(residual))


def power_beside(
    residual: NDArray[np.float64],
    reading: NDArray[np.float64],
    changes: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]],
) -> float:
    """Variance of a signal's fast noise that a reading's noise does not explain.

    A regression is used, since the difference of two variances would be uncertain by a share of
    the larger one.

    Parameters
    ----------
    residual, reading : ndarray, shape (n,)
        Parts of the signal and of the reading that are not motion.
    changes : sequence of two ndarray, shape (n,)
        Changes of signal and reading in each run with noise of the reading alone.
    """
    both = [(_fast_bins(own), _fast_bins(seen)) for own, seen in changes]
    cross = np.sum([own * seen.conj() for own, seen in both], axis=0)
    power = np.sum([np.abs(seen) ** 2 for _, seen in both], axis=0)
    width = max(3, power.size // 10)
    smooth = [uniform_filter1d(part, width) for part in (np.real(cross), np.imag(cross), power)]
    gain = (smooth[0] + 1j * smooth[1]) / np.maximum(smooth[2], 1e-300)
    return _level(_fast_bins(residual) - gain * _fast_bins(reading))


def _fast_bins(residual: NDArray[np.float64]) -> Spectrum:
    """Spectrum near the Nyquist frequency; its mean square is the variance of white noise."""
    n = residual.size
    # The second difference keeps slow parts out of the fast bins, the taper single lines.
    taper = np.hanning(n - 2)
    spectrum = np.fft.rfft(taper * np.diff(residual, 2)) / np.sqrt(np.sum(taper**2))
    frequency = np.fft.rfftfreq(n - 2)
    band = (frequency > _NOISE_BAND[0]) & (frequency < _NOISE_BAND[1])
    bins: Spectrum = spectrum[band] / (2.0 * np.sin(np.pi * frequency[band])) ** 2
    return bins


def _level(bins: Spectrum) -> float:
    # The median of an exponential variable is ln 2 times its mean, and ignores single lines.
    return float(np.median(np.abs(bins) ** 2) / np.log(2.0))


def loop_covariance(window: Window, changes: Sequence[Sequence[NDArray[np.float64]]]) -> Spectrum:
    """Covariance of the simulated signals' changes under noise, smoothed over frequency.

    Parameters
    ----------
    window : Window
        Stretch that is scored.
    changes : sequence of sequences of ndarray
        One sequence a noise run, one array a signal.
    """
    n, m = window.frequencies.size, window.n_signals
    total = np.zeros((n, m, m), dtype=complex)
    for change in changes:
        spectrum = window.spectra(change)
        total += np.einsum("fi,fj->fij", spectrum, spectrum.conj())
    total /= max(1, len(changes))
    width = max(3, n // 40)
    smooth: Spectrum = uniform_filter1d(total.real, width, axis=0, mode="nearest") + (
        1j * uniform_filter1d(total.imag, width, axis=0, mode="nearest")
    )
    return smooth


def tolerance_covariance(window: Window, record: Record, positions: frozenset[str]) -> Spectrum:
    """Diagonal covariance of a tolerance: share of each spectrum, smoothed over an octave."""
    spectrum = window.spectra([_carrier(s) for s in record.signals])
    # A free axis answers a force by 1/f^2: smoothed as an acceleration, its slow part does not
    # spread over the fast part.
    free = np.array([s.driving is not None for s in record.signals])
    steep = np.where(free, np.maximum(window.frequencies, _LOWEST_HZ)[:, None] ** 4, 1.0)
    power = _octaves(np.abs(spectrum) ** 2 * steep, window.frequencies) / steep
    shares = np.array([_share(signal, positions) for signal in record.signals], dtype=float)
    return _diagonal(power * shares**2)


def white_covariance(window: Window, variances: Sequence[float]) -> Spectrum:
    """Covariance of independent white noise, the same at all frequencies.

    Parameters
    ----------
    window : Window
        Stretch that is scored.
    variances : sequence of float
        [unit of the signal squared]
    """
    return _diagonal(np.tile(window.white(variances), (window.frequencies.size, 1)))


def excess_of_repeats(
    window: Window,
    first: Record,
    second: Record,
    known: Spectrum,
) -> Spectrum:
    """Covariance of the difference of repeated recordings beyond known noise.

    Parameters
    ----------
    window : Window
        Of both recordings.
    first, second : Record
        Two runs under the same inputs and parameters.
    known : ndarray, shape (n_bins, n_signals, n_signals)
        Covariance of the known noise.
    """
    rows = [
        min(a.values.size, b.values.size)
        for a, b in zip(first.signals, second.signals, strict=True)
    ]
    columns = []
    for a, b, n in zip(first.signals, second.signals, rows, strict=True):
        difference = np.zeros(a.values.size)
        difference[:n] = a.values[:n] - b.values[:n]
        columns.append(difference)
    power = _octaves(0.5 * np.abs(window.spectra(columns)) ** 2, window.frequencies)
    own = np.real(np.einsum("fii->fi", known))
    return _diagonal(np.maximum(power - own, 0.0))


def _carrier(signal: ScoredSignal) -> NDArray[np.float64]:
    """Signal of which the tolerance is a share."""
    return signal.values - signal.values[0] if signal.driving is None else signal.driving


def _share(signal: ScoredSignal, positions: frozenset[str]) -> float:
    if signal.driving is not None or signal.name not in positions:
        return TOLERANCE
    return POSITION_TOLERANCE


def _octaves(power: NDArray[np.float64], frequencies: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean over half an octave to each side, at least two bins."""
    n = frequencies.size
    bins = np.arange(n)
    low = np.minimum(np.floor(bins / np.sqrt(2.0)).astype(int), np.maximum(bins - 2, 0))
    high = np.minimum(np.maximum(np.ceil(bins * np.sqrt(2.0)).astype(int), bins + 2), n - 1) + 1
    total = np.concatenate([np.zeros((1, power.shape[1])), np.cumsum(power, axis=0)])
    mean: NDArray[np.float64] = (total[high] - total[low]) / (high - low)[:, None]
    return mean


def _diagonal(values: NDArray[np.float64]) -> Spectrum:
    n, m = values.shape
    matrix = np.zeros((n, m, m), dtype=complex)
    matrix[:, range(m), range(m)] = values
    return matrix
