"""Noise that the controller read, as far as the recorded signals tell it, to be played."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.noise.places import Levels, covariance
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, through
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.runs.simulated import PlayedNoise
from gmfbo.diagnosis.runs.simulations import Simulations

Array = NDArray[np.float64]

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
    level = kernels.beyond_rounding(levels.ports["sensor"])
    columns = [np.zeros(record.plan.grid.size) for record in simulations.records]
    rates = problem.rates(fitted.values)
    for segment, residual, rate in zip(problem.segments, fitted.residual, rates, strict=True):
        grid = simulations.records[segment.record].plan.grid
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
        seen = rfft(residual, length, axis=-1).T
        columns[segment.record][rows] = irfft(np.sum(gain * seen, axis=1), length)[: rows.size]
    return tuple(
        PlayedNoise(at_port, linear_answer(simulations, kernels, k, own), port)
        for k, own in enumerate(map(from_rest, columns))
        for port, at_port in kernels.of(k).sensed(own).items()
    )


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
