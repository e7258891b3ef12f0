"""What a small signal at a port changes in the recorded outputs: impulse responses.

A feature of a trajectory, sent through them, shows in the outputs what it would change if it
acted at the port; sent backwards, residuals show which instants at the port they speak of.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.runs.scored_record import with_same_gains
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.screening.impulse_response import (
    Sampling,
    impulse_responses,
    random_binary,
    sampling,
)
from gmfbo.errors import SimulationError

Array = NDArray[np.float64]

_SIZE = 0.02  # of the port's range: above encoder counts, too little to change the motion


@dataclass(frozen=True, eq=False)
class PortResponse:
    """Impulse responses from a port to every scored signal of each recording.

    Attributes
    ----------
    port : str
        Where the signal enters.
    step : float
        [s] Of the communication grid; a signal at the port is held over it.
    kernels : tuple of tuples of ndarray, shape (n_taps,)
        [signal's unit / port's unit] One tuple a recording, one array a signal.
    samplings : tuple of tuples of Sampling
        The same for the signals' own times.
    rows : tuple of int
        Communication points of each recording.
    size : float
        [port's unit] Of the excitation.
    """

    port: str
    step: float
    kernels: tuple[tuple[Array, ...], ...]
    samplings: tuple[tuple[Sampling, ...], ...]
    rows: tuple[int, ...]
    size: float

    def filtered(self, record: int, column: Array) -> tuple[Array, ...]:
        """Change of the signals by a signal at the port.

        Parameters
        ----------
        record : int
            Which recording.
        column : ndarray, shape (..., rows)
            [port's unit] Held from each communication point to the next.

        Returns
        -------
        tuple of ndarray, shape (..., n_samples of that signal)
        """
        length, spectra = self._spectra[record]
        own = rfft(column, length)
        rows = self.rows[record]
        return tuple(
            samples.read(irfft(own * spectrum, length)[..., :rows])
            for spectrum, samples in zip(spectra, self.samplings[record], strict=True)
        )

    def backwards(self, record: int, signals: Sequence[Array]) -> Array:
        """Transpose of `filtered`: sum over the signals, shape (rows,).

        Parameters
        ----------
        record : int
            Which recording.
        signals : sequence of ndarray, shape (n_samples of that signal,)
            One array a signal.
        """
        length, spectra = self._spectra[record]
        rows = self.rows[record]
        total = np.zeros(length // 2 + 1, dtype=complex)
        for values, spectrum, samples in zip(signals, spectra, self.samplings[record], strict=True):
            total += np.conj(spectrum) * rfft(samples.spread(values, rows), length)
        field: Array = irfft(total, length)[:rows]
        return field

    def gains(self, record: int, frequencies: Array) -> NDArray[np.complex128]:
        """Frequency responses, shape (n_frequencies, n_signals).

        Parameters
        ----------
        record : int
            Which recording.
        frequencies : ndarray, shape (n_frequencies,)
            [Hz]
        """
        columns = []
        for kernel in self.kernels[record]:
            lags = self.step * np.arange(kernel.size)
            columns.append(np.exp(-2j * np.pi * np.outer(frequencies, lags)) @ kernel)
        return np.stack(columns, axis=-1)

    @cached_property
    def _spectra(self) -> tuple[tuple[int, tuple[NDArray[np.complex128], ...]], ...]:
        found = []
        for rows, own in zip(self.rows, self.kernels, strict=True):
            length = next_fast_len(rows + max(kernel.size for kernel in own), real=True)
            length += length % 2
            found.append((length, tuple(rfft(kernel, length) for kernel in own)))
        return tuple(found)


def between_points(column: Array) -> Array:
    """Mean over each communication step of a state known at its ends, shape (..., rows).

    A feature evaluated at the beginning of a step and held would act half a step late.
    """
    mean = np.array(column, dtype=float)
    mean[..., :-1] = 0.5 * (column[..., :-1] + column[..., 1:])
    return mean


def measure_port_response(
    case: Case, port: str, rng: np.random.Generator, base: Fitted | None = None
) -> PortResponse | None:
    """Excite a port by a random binary signal and estimate what it does to the outputs.

    Recordings under the same parameters share one response.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    port : str
        Such as `torque`.
    rng : numpy Generator
        Of the excitation.
    base : Fitted, optional
        About which model; the refitted twin without it.

    Returns
    -------
    PortResponse or None
        None where the twin has no such port.

    Raises
    ------
    SimulationError
        The twin cannot be simulated under the excitation.
    """
    base = base or case.base
    if port not in base.simulated[0].response.ports:
        return None
    simulations, records = case.simulations, case.simulations.records
    groups = with_same_gains(records)
    longest = [max(group, key=lambda k: records[k].plan.grid.size) for group in groups]
    size = _SIZE * _range_of(case, port)
    columns = {k: random_binary(records[k].plan.grid.size, rng) for k in longest}
    excited = _Excited(simulations, port, base, columns)
    whole = simulations.map(excited.answer, [(k, size) for k in longest])
    step = float(np.diff(records[0].plan.grid[:2])[0])
    kernels: dict[int, dict[str, Array]] = {}
    for group, k, changes in zip(groups, longest, whole, strict=True):
        kernels |= dict.fromkeys(group, impulse_responses(columns[k], changes, step))
    return PortResponse(
        port,
        step,
        tuple(
            tuple(kernels[k][signal.name] for signal in record.signals)
            for k, record in enumerate(records)
        ),
        tuple(
            tuple(sampling(record.plan.grid, signal.time) for signal in record.signals)
            for record in records
        ),
        tuple(record.plan.grid.size for record in records),
        size,
    )


@dataclass(frozen=True, eq=False)
class _Excited:
    """A fitted model under columns of unit size at a port, by recording."""

    simulations: Simulations
    port: str
    base: Fitted
    columns: dict[int, Array]

    def answer(self, order: tuple[int, float]) -> dict[str, Array]:
        """Change of all signals on the grid over the size of what excites them."""
        k, size = order
        point = self.base.hypothesis.point(self.base.x)
        run = self.simulations.run_one(point, k, excitation={self.port: size * self.columns[k]})
        if not run.finite:
            raise SimulationError(
                f"excited at the {self.port} port: {run.response.outcome.message}"
            )
        before = _on_grid(self.simulations, self.base.simulated[k])
        after = _on_grid(self.simulations, run)
        return {name: (after[name] - before[name]) / size for name in after}


def _range_of(case: Case, port: str) -> float:
    excitation = case.setting.excitation
    ranges = {"torque": excitation.torque, "command": excitation.command}
    return ranges.get(port, 0.1 * excitation.stroke)


def _on_grid(simulations: Simulations, run: Simulated) -> dict[str, Array]:
    """All signals that may be scored, shape (rows,) each."""
    response = run.response
    return {
        name: response.new[name] if name in simulations.new_rows else held
        for name, held in response.held.items()
    }
