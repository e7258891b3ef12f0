"""Noise of three places: read by the controller, added by the logger, and a torque at the shaft.

One level each for all recordings, by the Whittle likelihood (Whittle 1953) of what a fit leaves.
What the controller reads goes round the loop and reaches all signals together, what the logger adds
stays in its column: their levels follow from the covariance of the signals at each frequency.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.numbers import BAND, BLOCK_ROWS, FLOOR, TORQUE_TIME
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.comparison.segments import Segment

Array = NDArray[np.float64]
Spectrum = NDArray[np.complex128]


@dataclass(frozen=True)
class Levels:
    """Standard deviations of the noise, by place.

    Attributes
    ----------
    ports : mapping of str to float
        [FMU's unit] `sensor`: what the controller reads, white; `torque` and `command`: coloured,
        with `time`.
    own : mapping of str to float
        [SI] What the logger adds to each signal, white.
    jitter : float
        [s] Of the logger's clock, seen in the positions.
    astray : mapping of str to float
        [FMU's unit] By port, what reaches each signal by itself, as large as the port's path makes
        it: a loop that saturates or sticks does not send on what a push of it sends.
    time : float
        [s] Correlation time of what is not white.
    """

    ports: Mapping[str, float]
    own: Mapping[str, float]
    jitter: float = 0.0
    astray: Mapping[str, float] = field(default_factory=dict)
    time: float = TORQUE_TIME

    def with_ports(self, **levels: float) -> Levels:
        """The same with other levels at some ports."""
        return replace(self, ports={**self.ports, **levels})

    def with_missing(self, **levels: float) -> Levels:
        """The same with other levels at some ports, and nothing astray."""
        return replace(self.with_ports(**levels), astray={})

    def missing(self, port: str) -> float:
        """[FMU's unit] What is missing at a port, with what goes astray."""
        return float(np.hypot(self.ports.get(port, 0.0), self.astray.get(port, 0.0)))

    def of(self, name: str) -> float:
        """Level of a place, as `estimated` names them."""
        kind, _, which = name.partition(":")
        if kind == "jitter":
            return self.jitter
        if kind == "astray":
            return self.astray.get(which, 0.0)
        return (self.ports if kind == "port" else self.own)[which]


def covariance(
    levels: Levels,
    kernels: PortKernels,
    names: tuple[str, ...],
    frequencies: Array,
    square_rates: Array,
) -> Spectrum:
    """Covariance of the signals' spectra a sample, shape (n_frequencies, m, m).

    Parameters
    ----------
    levels : Levels
        Of the noise.
    kernels : PortKernels
        Paths from the ports to the signals.
    names : tuple of str
        The m signals.
    frequencies : ndarray, shape (n_frequencies,)
        [Hz]
    square_rates : ndarray, shape (m,)
        [SI^2/s^2] Mean square rate of the signals that jitter shows in; 0 for others.
    """
    total = np.zeros((frequencies.size, len(names), len(names)), dtype=np.complex128)
    for port, level in levels.ports.items():
        if level <= 0.0 or port not in kernels.kernels:
            continue
        answer = kernels.spectra(port, names, frequencies).T
        colour = 1.0 if port == "sensor" else coloured(frequencies, kernels.step, levels.time)
        outer = answer[:, :, None] * answer[:, None, :].conj()
        total += level**2 * np.reshape(colour * np.ones(frequencies.size), (-1, 1, 1)) * outer
    own = np.array([levels.own[name] ** 2 for name in names]) + levels.jitter**2 * square_rates
    diagonal = np.einsum("fii->fi", total)
    for port, level in levels.astray.items():
        if level > 0.0 and port in kernels.kernels:
            power = np.abs(kernels.spectra(port, names, frequencies).T) ** 2
            diagonal += level**2 * coloured(frequencies, kernels.step, levels.time)[:, None] * power
    diagonal += FLOOR * diagonal.real + own
    return total


def coloured(frequencies: Array, step: float, time: float) -> Array:
    """Spectrum a sample of an exponentially correlated signal of unit variance."""
    return 2.0 * (time / step) / (1.0 + (2.0 * np.pi * frequencies * time) ** 2)


@dataclass(frozen=True, eq=False)
class Periodograms:
    """Spectra of short blocks, or of whole segments, of signals with the same names.

    Attributes
    ----------
    names : tuple of str
        The m signals.
    frequencies : ndarray, shape (n_frequencies,)
        [Hz]
    spectra : ndarray, shape (n_blocks, n_frequencies, m)
        Scaled so that white noise of unit variance gives one.
    square_rates : ndarray, shape (n_blocks, m)
        As in `covariance`.
    record : int
        One of their recordings, which all have the same gains.
    """

    names: tuple[str, ...]
    frequencies: Array
    spectra: Spectrum
    square_rates: Array
    record: int = 0

    def alike(self, levels: Levels) -> list[NDArray[np.intp]]:
        """Blocks of about the same rate, in classes a factor of four apart."""
        total = self.square_rates.sum(1)
        if levels.jitter <= 0.0 or total.max() <= 0.0:
            return [np.arange(total.size)]
        classes = np.floor(np.log(np.maximum(total / total.max(), 4.0**-8)) / np.log(4.0))
        return [np.flatnonzero(classes == c) for c in np.unique(classes)]


def blocks_of(
    segments: Sequence[Segment],
    residuals: Sequence[Array],
    rates: Sequence[Array],
    kernels: PortKernels,
    band: float = BAND,
    rows: int = BLOCK_ROWS,
    white_by: Levels | None = None,
) -> list[Periodograms]:
    """Periodograms of half overlapping blocks, those above a share of the Nyquist frequency.

    Blocks of one group have the same signals, length and paths of noise.

    Parameters
    ----------
    segments : sequence of Segment
        Stretches that are compared.
    residuals, rates : sequence of ndarray, shape (m, n)
        [SI], [SI/s] By segment.
    kernels : PortKernels
        Paths of noise.
    band : float
        Share of the Nyquist frequency.
    rows : int
        Of a block; 0 for whole segments.
    white_by : Levels, optional
        By which the residuals were whitened. Their spectra are coloured again: what leaks from
        strong frequencies into weak ones would be taken for noise there (Blackman and Tukey 1958).
    """
    groups: dict[tuple[tuple[str, ...], int, int], list[tuple[Segment, Spectrum, Array]]] = {}
    for segment, residual, rate in zip(segments, residuals, rates, strict=True):
        length = min(rows, residual.shape[1]) if rows else residual.shape[1]
        taper = np.hanning(length + 2)[1:-1] if rows else _flat(length)
        taper = taper / np.sqrt(np.sum(taper**2))
        keep = slice(max(1, int(np.ceil(band * (length // 2)))) if band else 0, (length + 1) // 2)
        for start in range(0, residual.shape[1] - length + 1, max(1, length // 2)):
            part = slice(start, start + length)
            spectrum = np.fft.rfft(residual[:, part] * taper, axis=1)[:, keep].T
            found = (segment, spectrum, (rate[:, part] ** 2).mean(1))
            paths = id(kernels.of(segment.record))
            groups.setdefault((segment.names, length, paths), []).append(found)
    made = []
    for (names, n, _), blocks in groups.items():
        first = max(1, int(np.ceil(band * (n // 2)))) if band else 0
        own = blocks[0][0]
        bins = np.arange(first, (n + 1) // 2) / (own.spacing * n)
        spectra, square_rates = np.stack([b[1] for b in blocks]), np.stack([b[2] for b in blocks])
        if white_by is not None:
            paths_of = kernels.of(own.record)
            s = covariance(white_by, paths_of, names, bins, np.zeros(len(names)))
            spectra = np.einsum("fij,bfj->bfi", np.linalg.cholesky(s), spectra)
        made.append(Periodograms(names, bins, spectra, square_rates, own.record))
    return made


def _flat(length: int) -> Array:
    """Cosine taper of a quarter at each end (Tukey 1967).

    A recording is cut where noise goes on. Signals that answer the same noise are alike but for
    that cut, and what leaks from it would be taken for noise of their own.
    """
    ramp = max(1, length // 4)
    taper = np.ones(length)
    taper[:ramp] = np.sin(0.5 * np.pi * (np.arange(ramp) + 0.5) / ramp) ** 2
    taper[length - ramp :] = taper[:ramp][::-1]
    return taper


def with_level(levels: Levels, name: str, value: float) -> Levels:
    """The same levels with another one of a place, as `estimated` names them."""
    kind, _, which = name.partition(":")
    if kind == "jitter":
        return replace(levels, jitter=value)
    if kind == "port":
        return levels.with_ports(**{which: value})
    if kind == "astray":
        return replace(levels, astray={**levels.astray, which: value})
    return replace(levels, own={**levels.own, which: value})


def split(
    levels: Levels,
    free: Sequence[str],
    kernels: PortKernels,
    names: tuple[str, ...],
    frequencies: Array,
    square_rates: Array,
) -> tuple[Spectrum, Spectrum]:
    """Covariance as a sum: of what stays, and a variance of each free place times its unit.

    Parameters
    ----------
    levels : Levels
        Of what stays.
    free : sequence of str
        The k places, as `estimated` names them.
    kernels, names, frequencies, square_rates
        As of `covariance`.

    Returns
    -------
    tuple of ndarray, shape (n_frequencies, m, m) and (k, n_frequencies, m, m)
    """
    ports, own = (dict.fromkeys(places, 0.0) for places in (levels.ports, levels.own))
    nothing = Levels(ports, own, time=levels.time)
    at = levels
    for name in free:
        at = with_level(at, name, 0.0)

    def alone(one: Levels) -> Spectrum:
        return covariance(one, kernels, names, frequencies, square_rates)

    return alone(at), np.stack([alone(with_level(nothing, name, 1.0)) for name in free])


def summed(parts: Sequence[tuple[float, Array]]) -> tuple[float, Array]:
    """Sum of values, and of their slopes.

    Parameters
    ----------
    parts : sequence of (float, ndarray, shape (k,))
        A value and its k slopes.
    """
    slopes: Array = sum((own for _, own in parts), np.zeros(1))
    return sum(value for value, _ in parts), slopes
