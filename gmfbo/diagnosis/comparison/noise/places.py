"""Noise of three places: read by the controller, added by the logger, and a torque at the shaft.

One level each for all recordings, by the Whittle likelihood (Whittle 1953) of what a fit leaves.
What the controller reads goes round the loop and reaches all signals together, what the logger adds
stays in its column: their levels follow from the covariance of the signals at each frequency.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

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
        with the correlation time of the table.
    own : mapping of str to float
        [SI] What the logger adds to each signal, white.
    jitter : float
        [s] Of the logger's clock, seen in the positions.
    """

    ports: Mapping[str, float]
    own: Mapping[str, float]
    jitter: float = 0.0

    def with_ports(self, **levels: float) -> Levels:
        """The same with other levels at some ports."""
        return replace(self, ports={**self.ports, **levels})

    def of(self, name: str) -> float:
        """Level of a place, as `estimated` names them."""
        kind, _, which = name.partition(":")
        if kind == "jitter":
            return self.jitter
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
        colour = 1.0 if port == "sensor" else _coloured(frequencies, kernels.step)
        outer = answer[:, :, None] * answer[:, None, :].conj()
        total += level**2 * np.reshape(colour * np.ones(frequencies.size), (-1, 1, 1)) * outer
    own = np.array([levels.own[name] ** 2 for name in names]) + levels.jitter**2 * square_rates
    diagonal = np.einsum("fii->fi", total)
    diagonal += FLOOR * diagonal.real + own
    return total


def _coloured(frequencies: Array, step: float) -> Array:
    """Spectrum a sample of an exponentially correlated signal of unit variance."""
    return 2.0 * (TORQUE_TIME / step) / (1.0 + (2.0 * np.pi * frequencies * TORQUE_TIME) ** 2)


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

    def deviances(self, levels: Levels, kernels: PortKernels) -> tuple[Array, Array]:
        """Whitened squares and log determinants, summed over the frequencies, shape (n_blocks,)."""
        squares, logs = np.empty(len(self.spectra)), np.empty(len(self.spectra))
        kernels = kernels.of(self.record)
        for rows in self._alike(levels):
            rates = self.square_rates[rows].mean(0)
            s = covariance(levels, kernels, self.names, self.frequencies, rates)
            factor = np.linalg.cholesky(s)
            white = np.einsum("fij,bfj->bfi", np.linalg.inv(factor), self.spectra[rows])
            squares[rows] = np.sum(white.real**2 + white.imag**2, axis=(1, 2))
            logs[rows] = 2.0 * np.log(np.einsum("fii->fi", factor).real).sum()
        return squares, logs

    def _alike(self, levels: Levels) -> list[NDArray[np.intp]]:
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
) -> list[Periodograms]:
    """Periodograms of half overlapping blocks, those above a share of the Nyquist frequency.

    Blocks of one group have the same signals, length and paths of noise.
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


def estimated(
    kernels: PortKernels,
    periodograms: Sequence[Periodograms],
    least: Levels,
    free: Sequence[str],
    near: Levels | None = None,
) -> Levels:
    """Levels of greatest likelihood: robust first, then without blocks that hold more than noise.

    Parameters
    ----------
    kernels : PortKernels
        Paths from the ports to the signals.
    periodograms : sequence of Periodograms
        Of what a fit leaves.
    least : Levels
        Below which no level is looked for.
    free : sequence of str
        What is estimated: `port:NAME`, `own:SIGNAL`, `jitter`; the others stay as in `least`.
    near : Levels, optional
        Where the search begins; without it several starts are tried.
    """
    low = np.log([least.of(name) for name in free])

    def at(x: Array) -> Levels:
        levels = least
        for name, value in zip(free, np.exp(x), strict=True):
            levels = with_level(levels, name, float(value))
        return levels

    def robust(x: Array) -> float:
        total = 0.0
        for group in periodograms:
            squares, logs = group.deviances(at(x), kernels)
            n = group.frequencies.size * len(group.names)
            total += float(np.sum((1.0 + n) * np.log1p(squares) + logs))
        return total

    bounds = [(a, a + 25.0) for a in low]
    if near is None:
        starts = _starts(free, low, kernels, periodograms)
        begin = min((np.array(c) for c in product(*starts)), key=robust)
        x = minimize(robust, begin, method="L-BFGS-B", bounds=bounds).x
    else:
        x = np.log([near.of(name) for name in free])
    for most in (2.0, 1.6, 1.6) if near is None else (1.6, 1.6):
        kept = _quiet(periodograms, at(x), kernels, most)

        def nll(x: Array, kept: list[NDArray[np.bool_]] = kept) -> float:
            total = 0.0
            for group, rows in zip(periodograms, kept, strict=True):
                squares, logs = group.deviances(at(x), kernels)
                total += float(np.sum((squares + logs)[rows]))
            return total

        x = minimize(nll, x, method="L-BFGS-B", bounds=bounds).x
    return at(x)


def _starts(
    free: Sequence[str], low: Array, kernels: PortKernels, periodograms: Sequence[Periodograms]
) -> list[list[float]]:
    """Two starts of each level: about all of a residual, and a twentieth of it."""
    found = []
    for name, least in zip(free, low, strict=True):
        largest = float(np.log(_largest(name, kernels, periodograms)))
        found.append([max(float(least), largest - step) for step in (0.7, 3.0)])
    return found


def _quiet(
    groups: Sequence[Periodograms], levels: Levels, kernels: PortKernels, most: float
) -> list[NDArray[np.bool_]]:
    """Blocks that hold no more than noise, among all of as many values, whatever their gains."""
    squares = [group.deviances(levels, kernels)[0] for group in groups]
    alike: dict[tuple[object, ...], list[Array]] = {}
    for group, own in zip(groups, squares, strict=True):
        alike.setdefault((group.names, group.frequencies.size), []).append(own)
    usual = {key: np.median(np.concatenate(found)) for key, found in alike.items()}
    return [
        own < most * usual[group.names, group.frequencies.size]
        for group, own in zip(groups, squares, strict=True)
    ]


def with_level(levels: Levels, name: str, value: float) -> Levels:
    """The same levels with another one of a place, as `estimated` names them."""
    kind, _, which = name.partition(":")
    if kind == "jitter":
        return replace(levels, jitter=value)
    if kind == "port":
        return levels.with_ports(**{which: value})
    return replace(levels, own={**levels.own, which: value})


def _largest(name: str, kernels: PortKernels, periodograms: Sequence[Periodograms]) -> float:
    """Level at which one place alone would make all of the residual of its best signal."""
    found = []
    kind, _, which = name.partition(":")
    for group in periodograms:
        power = np.median(np.abs(group.spectra) ** 2, axis=(0, 1)) / np.log(2.0)
        if kind == "own" and which in group.names:
            found.append(np.sqrt(power[group.names.index(which)]))
        elif kind == "port":
            paths = kernels.of(group.record)
            answer = np.abs(paths.spectra(which, group.names, group.frequencies)) ** 2
            colour = 1.0 if which == "sensor" else _coloured(group.frequencies, paths.step)
            unit = np.mean(answer * colour, axis=1)
            found.append(np.sqrt(np.min(power / np.maximum(unit, 1e-300))))
        elif kind == "jitter":
            rate = group.square_rates.mean(0)
            shown = rate > 0.0
            if shown.any():
                found.append(np.sqrt(np.min(power[shown] / rate[shown])))
    return float(max(found, default=1e-12)) or 1e-12
