"""Noise that the controller reads, as far as the recorded signals tell it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from gmfbo.diagnosis.comparison.noise_places import Levels, covariance
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, through
from gmfbo.diagnosis.comparison.posterior_mode import Fitted
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.runs.simulated import PlayedNoise
from gmfbo.diagnosis.runs.simulations import Simulations

Array = NDArray[np.float64]

_PADDED = 1.12  # times a segment


@dataclass(frozen=True, eq=False)
class _Stretch:
    """What a segment leaves open: rows of its recording, and the share of a white spectrum."""

    record: int
    rows: NDArray[np.intp]
    open: Array


@dataclass(frozen=True, eq=False)
class SensedNoise:
    """White noise of the sensor port, given what a fit leaves of the signals.

    Attributes
    ----------
    level : float
        [FMU's unit] Its standard deviation before the signals were seen.
    means : tuple of ndarray, shape (rows,)
        [FMU's unit] By recording, on its grid.
    stretches : tuple of _Stretch
        What the signals leave open; elsewhere all of it.
    """

    level: float
    means: tuple[Array, ...]
    stretches: tuple[_Stretch, ...]

    def played(self, simulations: Simulations, kernels: PortKernels) -> tuple[PlayedNoise, ...]:
        """Its mean, to be played into the twin.

        Parameters
        ----------
        simulations : Simulations
            Of the recordings.
        kernels : PortKernels
            Whose linear answer is taken out again: the covariance of the noise holds it.
        """
        return tuple(
            PlayedNoise(column, linear_answer(simulations, kernels, k, column))
            for k, column in enumerate(self.means)
        )

    def drawn(self, rng: np.random.Generator) -> list[Array]:
        """One realisation of each recording, shape (rows,)."""
        columns = [self.level * rng.standard_normal(mean.size) for mean in self.means]
        for stretch in self.stretches:
            length = 2 * (stretch.open.size - 1)
            white = rfft(rng.standard_normal(length))
            own: Array = irfft(white * np.sqrt(stretch.open), length)[: stretch.rows.size]
            columns[stretch.record][stretch.rows] = self.level * own
        return [_from_rest(a + b) for a, b in zip(self.means, columns, strict=True)]


def unsensed(simulations: Simulations, level: float) -> SensedNoise:
    """White noise of a level of which the signals were not asked.

    Parameters
    ----------
    simulations : Simulations
        Of the recordings.
    level : float
        [FMU's unit]
    """
    sizes = [record.plan.grid.size for record in simulations.records]
    return SensedNoise(level, tuple(np.zeros(n) for n in sizes), ())


def sensed_noise(
    problem: Problem, fitted: Fitted, kernels: PortKernels, levels: Levels
) -> SensedNoise:
    """Noise of the sensor port that makes what a fit leaves most likely (Wiener 1949).

    Parameters
    ----------
    problem : Problem
        Recordings.
    fitted : Fitted
        Whose residual is read.
    kernels : PortKernels
        Paths of noise.
    levels : Levels
        Of the noise, and of the inadequacy beside it.
    """
    simulations, level = problem.simulations, levels.ports["sensor"]
    means = [np.zeros(record.plan.grid.size) for record in simulations.records]
    found, rates = [], problem.rates(fitted.values)
    for segment, residual, rate in zip(problem.segments, fitted.residual, rates, strict=True):
        grid = simulations.records[segment.record].plan.grid
        inside = (grid > segment.time[0] - 1e-9) & (grid < segment.time[-1] + 1e-9)
        rows = np.flatnonzero(inside)
        if rows.size != segment.time.size:
            continue  # its rows are not those of the controller's reading
        length = next_fast_len(int(np.ceil(_PADDED * rows.size)), real=True)
        length += length % 2
        frequencies = np.arange(length // 2 + 1) / (length * segment.spacing)
        s = covariance(levels, kernels, segment.names, frequencies, (rate**2).mean(1))
        path = kernels.spectra("sensor", segment.names, frequencies).T
        gain = level**2 * np.linalg.solve(s, path[:, :, None])[:, :, 0].conj()
        seen = rfft(residual, length, axis=-1).T
        means[segment.record][rows] = irfft(np.sum(gain * seen, axis=1), length)[: rows.size]
        open_share = 1.0 - np.sum(gain * path, axis=1).real
        found.append(_Stretch(segment.record, rows, np.clip(open_share, 0.0, 1.0)))
    return SensedNoise(level, tuple(_from_rest(m) for m in means), tuple(found))


def linear_answer(
    simulations: Simulations, kernels: PortKernels, k: int, noise: Array
) -> tuple[Array, ...]:
    """[SI] What a linear path makes of noise in the simulated signals of a recording.

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
            through(noise, kernels.simulated["sensor"][signal.name]),
        )
        for signal in record.signals
    )


def _from_rest(noise: Array) -> Array:
    """Noise that begins at zero: its first row is held before the recording begins."""
    noise = noise.copy()
    noise[0] = 0.0
    return noise
