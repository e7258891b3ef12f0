"""Noise that the controller read, as far as the recorded signals tell it, to be played."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.heard_noise import HeardNoise
from gmfbo.diagnosis.comparison.noise.places import Levels, covariance
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, through
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.runs.simulated import PlayedNoise
from gmfbo.diagnosis.runs.simulations import Simulations

Array = NDArray[np.float64]
Spectrum = NDArray[np.complexfloating]

_PADDED = 1.12  # times a segment


def sensed_noise(
    problem: Problem, fitted: Fitted, kernels: PortKernels, levels: Levels
) -> tuple[PlayedNoise, ...]:
    """Noise of the sensor port that makes what a fit leaves most likely (Wiener 1949).

    Parameters
    ----------
    problem : Problem
        Recordings.
    fitted : Fitted
        Whose residual is read.
    kernels : PortKernels
        Paths of noise; what a linear one makes of it is taken out again when it is played, since
        the covariance of the noise holds it.
    levels : Levels
        Of the noise, and of the inadequacy beside it.

    Returns
    -------
    tuple of PlayedNoise
        By recording; none where its rows are not those of the controller's reading.
    """
    simulations = problem.simulations
    columns = [np.zeros(record.plan.grid.size) for record in simulations.records]
    for one in _readings(problem, fitted, kernels, levels):
        seen = rfft(fitted.residual[one.segment], one.length, axis=-1).T
        columns[one.record][one.rows] = one.told_by(seen)
    return tuple(
        PlayedNoise(at_port, linear_answer(simulations, kernels, k, own), port)
        for k, own in enumerate(map(from_rest, columns))
        for port, at_port in kernels.of(k).sensed(own).items()
    )


class UnheardNoise:
    """What `sensed_noise` does not tell of the noise.

    Noise is drawn with the signals that it makes, and what these tell of it is taken out
    (Matheron's rule; Hoffman and Ribak 1991).

    Parameters
    ----------
    problem, fitted, kernels, levels
        As of `sensed_noise`.
    """

    def __init__(
        self, problem: Problem, fitted: Fitted, kernels: PortKernels, levels: Levels
    ) -> None:
        self._level = level = kernels.beyond_rounding(levels.ports["sensor"])
        self._sizes = [record.plan.grid.size for record in problem.simulations.records]
        self._readings: list[tuple[_Reading, Spectrum]] = []
        for one in _readings(problem, fitted, kernels, levels):
            rest = one.covariance - level**2 * one.path[:, :, None] * one.path[:, None, :].conj()
            values, vectors = np.linalg.eigh(rest)
            roots = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
            self._readings.append((one, roots))

    def drawn(self, rng: np.random.Generator) -> list[Array]:
        """[FMU's unit] A draw of it by recording, each of shape (rows,)."""
        columns = [self._level * rng.standard_normal(size) for size in self._sizes]
        for one, roots in self._readings:
            noise = columns[one.record][one.rows]
            white = rng.standard_normal((one.path.shape[1], noise.size))
            made = np.einsum("fij,fj->fi", roots, rfft(white, one.length, axis=-1).T)
            seen = one.path * rfft(noise, one.length)[:, None] + made
            columns[one.record][one.rows] = noise - one.told_by(seen)
        return list(map(from_rest, columns))


@dataclass(frozen=True, eq=False)
class _Reading:
    """How the signals of a segment tell the noise that the controller read.

    `gain` and `path`, shape (n_frequencies, m), lead from the signals to the noise, and from the
    noise to the signals; `covariance`, shape (n_frequencies, m, m), is that of the signals.
    """

    segment: int
    record: int
    rows: NDArray[np.intp]
    length: int
    gain: Spectrum
    path: Spectrum
    covariance: Spectrum

    def told_by(self, seen: Spectrum) -> Array:
        """Noise in the rows that the spectra of signals tell, shape (n_rows,)."""
        return irfft(np.sum(self.gain * seen, axis=1), self.length)[: self.rows.size]


def _readings(
    problem: Problem, fitted: Fitted, kernels: PortKernels, levels: Levels
) -> Iterator[_Reading]:
    level = kernels.beyond_rounding(levels.ports["sensor"])
    rates = problem.rates(fitted.values)
    for k, (segment, rate) in enumerate(zip(problem.segments, rates, strict=True)):
        grid = problem.simulations.records[segment.record].plan.grid
        inside = (grid > segment.time[0] - 1e-9) & (grid < segment.time[-1] + 1e-9)
        rows = np.flatnonzero(inside)
        if rows.size != segment.time.size:
            continue
        length = next_fast_len(int(np.ceil(_PADDED * rows.size)), real=True)
        frequencies = np.arange(length // 2 + 1) / (length * segment.spacing)
        own = kernels.of(segment.record)
        s = covariance(levels, own, segment.names, frequencies, (rate**2).mean(1))
        path = own.spectra("sensor", segment.names, frequencies).T
        gain = level**2 * np.linalg.solve(s, path[:, :, None])[:, :, 0].conj()
        yield _Reading(k, segment.record, rows, length, np.asarray(gain), path, s)


def heard_about(
    problem: Problem, row: Fitted, left: Fitted, kernels: PortKernels, levels: Levels
) -> HeardNoise:
    """The noise, and the point of a fit about which it is played.

    Parameters
    ----------
    problem, kernels, levels
        As of `sensed_noise`.
    row : Fitted
        The fit.
    left : Fitted
        The same, without what errors of the simulation made of its residual.
    """
    linear = tuple(c for c in row.hypothesis.effects if c.law.is_linear)
    played = sensed_noise(problem, left, kernels, levels)
    return HeardNoise(played, replace(row.hypothesis, effects=linear), row.parameters)


def linear_answer(
    simulations: Simulations, kernels: PortKernels, k: int, noise: Array
) -> tuple[Array, ...]:
    """[SI] What a linear path makes of the sensor's noise in the simulated signals of a recording.

    Parameters
    ----------
    simulations : Simulations
        Of the recordings.
    kernels : PortKernels
        The path.
    k : int
        Index of the recording.
    noise : ndarray, shape (rows,)
        [FMU's unit]
    """
    record = simulations.records[k]
    return tuple(
        np.interp(
            signal.time,
            record.plan.grid,
            through(noise, kernels.of(k).simulated["sensor"][signal.name]),
        )
        for signal in record.signals
    )


def from_rest(noise: Array) -> Array:
    """Noise that begins at zero: its first row is held before the recording begins, shape (n,)."""
    noise = noise.copy()
    noise[0] = 0.0
    return noise
