"""Answer of all signals to a push at each port: the paths of noise and of missing torque."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from gmfbo.diagnosis.runs.quantum import resolution
from gmfbo.diagnosis.runs.scored_record import with_same_gains
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.sources.twin.response import Response

Array = NDArray[np.float64]
Spectrum = NDArray[np.complex128]

_LONGEST_S, _LEAST_TAPS = 2.0, 2000  # whichever is longer: a loop forgets by its slowest integrator
_PUSH, _MOST_PUSH = 1e-5, 0.1
_READ, _ACTING = "position as read", "command as made"
_COUNTS = 10.0  # that an encoder in the twin counts of a push: less would be its rounding


@dataclass(frozen=True, eq=False)
class Pushed:
    """What a push of the torque makes in a closed loop, per FMU's unit of the port.

    Attributes
    ----------
    position : ndarray, shape (taps,)
        [SI] As the controller reads it at the beginning of a row.
    command : ndarray, shape (taps,)
        [SI] That it makes of this reading.
    """

    position: Array
    command: Array


@dataclass(frozen=True, eq=False)
class PortKernels:
    """Impulse responses of the signals, by port.

    Attributes
    ----------
    kernels : mapping of str to mapping of str to ndarray, shape (taps,)
        [SI unit of the signal / FMU's unit of the port] By port, then by signal; the first tap is
        of the row in which the push began.
    step : float
        [s] Between taps.
    simulated : mapping of str to mapping of str to ndarray, shape (taps,)
        [SI unit of the signal / FMU's unit of the port] Answers of the simulation, without what
        the log alone has of them; not of the sensor where a loop holds an open-loop twin.
    others : mapping of int to PortKernels
        Of recordings with other gains, by their index.
    controller : ndarray, shape (taps,), or None
        [FMU's unit of the torque port / FMU's unit of the position] Torque that the controller
        makes of a push of its reading, where that stands for a sensor port.
    pushed : Pushed or None
        What a push of the torque makes.
    rounding : float
        [FMU's unit] Standard deviation of what an encoder in the twin rounds away: 0 where its
        position comes in no counts.
    is_counted : bool
        Whether simulations round as well.
    """

    kernels: Mapping[str, Mapping[str, Array]]
    step: float
    simulated: Mapping[str, Mapping[str, Array]] = field(default_factory=dict)
    others: Mapping[int, PortKernels] = field(default_factory=dict)
    controller: Array | None = None
    pushed: Pushed | None = None
    rounding: float = 0.0
    is_counted: bool = True
    _known: dict[tuple[object, ...], Spectrum] = field(default_factory=dict)

    def of(self, record: int) -> PortKernels:
        """Those of a recording, by its index."""
        return self.others.get(record, self)

    def beyond_rounding(self, level: float) -> float:
        """[FMU's unit] Noise of the reading that a simulation without noise has not: its rounding.

        Parameters
        ----------
        level : float
            [FMU's unit] Standard deviation of all noise of the reading.
        """
        known = self.rounding if self.is_counted else 0.0
        return float(np.sqrt(max(level**2 - known**2, 0.0)))

    def sensed(self, noise: Array) -> dict[str, Array]:
        """[FMU's unit] What plays noise of the sensor, by port, shape (rows,).

        Parameters
        ----------
        noise : ndarray, shape (rows,)
            [FMU's unit] Of the reading.
        """
        if self.controller is None:
            return {"sensor": noise}
        return {"torque": through(noise, self.controller)}

    def spectra(self, port: str, names: tuple[str, ...], frequencies: Array) -> Spectrum:
        """Frequency responses of some signals, shape (m, n_frequencies).

        Parameters
        ----------
        port : str
            Where the push acts.
        names : tuple of str
            The m signals.
        frequencies : ndarray, shape (n_frequencies,)
            [Hz]
        """
        key = port, names, frequencies.size, float(frequencies[0]), float(frequencies[-1])
        if key not in self._known:
            kernels = np.stack([self.kernels[port][name] for name in names])
            self._known[key] = _transformed(kernels, self.step, frequencies)
        return self._known[key]


def _transformed(kernels: Array, step: float, frequencies: Array) -> Spectrum:
    """Fourier transforms of the rows of kernels, shape (m, n_frequencies)."""
    taps = kernels.shape[1]
    if frequencies.size > 1 and frequencies[0] == 0.0:
        length = round(1.0 / (float(frequencies[1]) * step))
        own = np.arange(frequencies.size) / (length * step)
        fits = taps <= length and frequencies.size <= length // 2 + 1
        # A clock that is off by a millionth turns the last taps by more than rounding.
        if fits and np.allclose(own, frequencies, rtol=1e-12, atol=0.0):
            found: Spectrum = rfft(kernels, length, axis=-1)[:, : frequencies.size]
            return found
    turn = np.exp(-2j * np.pi * step * np.outer(np.arange(taps), frequencies))
    whole: Spectrum = kernels @ turn
    return whole


def port_kernels(
    simulations: Simulations,
    point: Point,
    sizes: Mapping[str, float],
    position: str | None,
    to_si: float,
    command: str | None,
    rounded: float = 0.0,
) -> PortKernels:
    """Push each port for one row in the middle of the longest recording of each set of gains.

    Parameters
    ----------
    simulations : Simulations
        Simulators of the twin.
    point : Point
        Values at which the twin runs.
    sizes : mapping of str to float
        [FMU's unit] By port, what counts as large there; the push is a small share of it.
    position : str or None
        Output that is the reading of the position: its noise is in the log as well.
    to_si : float
        [SI unit / FMU's unit] Of the position.
    command : str or None
        Output that is the controller's command: what is added to it is in the log as well.
    rounded : float
        [SI unit] Count of the encoder, where the twin is simulated without its counts.
    """
    sizes_of = [record.plan.grid.size for record in simulations.records]
    first, *others = sorted(
        with_same_gains(simulations.records), key=lambda group: -max(sizes_of[k] for k in group)
    )

    def measured(group: Sequence[int]) -> PortKernels:
        longest = max(group, key=lambda k: sizes_of[k])
        return _in_recording(simulations, longest, point, sizes, position, to_si, command, rounded)

    found = {k: kernels for group in others for kernels in [measured(group)] for k in group}
    return replace(measured(first), others=found)


def _in_recording(
    simulations: Simulations,
    k: int,
    point: Point,
    sizes: Mapping[str, float],
    position: str | None,
    to_si: float,
    command: str | None,
    rounded: float,
) -> PortKernels:
    grid = simulations.records[k].plan.grid
    step = float(grid[1] - grid[0])
    taps = int(min(max(round(_LONGEST_S / step), _LEAST_TAPS), grid.size // 2))
    first = grid.size - taps
    base = simulations.run_one(point, k)
    is_open = simulations.tracking is not None
    ports = [p for p in sizes if p in base.response.ports or (p == "sensor" and is_open)]

    # Without those counts another encoder of the twin may still count.
    quantum = rounded or _count(base.response, position)

    def changes(port: str, size: float) -> dict[str, Array]:
        push = np.zeros(grid.size)
        push[first] = size
        if port == "sensor" and is_open:
            run = simulations.run_one(point, k, measured_noise=push)
        else:
            run = simulations.run_one(point, k, excitation={port: push})
        found = _changed(simulations, run.response, base.response)
        if port == "torque" and position is not None and command is not None:
            found[_READ] = run.response.held[position] - base.response.held[position]
            found[_ACTING] = run.response.new[command] - base.response.new[command]
        return {name: change[first:] for name, change in found.items()}

    def one(port: str) -> dict[str, Array]:
        size, most = _PUSH * sizes[port], _MOST_PUSH * sizes[port]
        found = changes(port, size)
        while quantum > 0.0 and np.ptp(found[str(position)]) < _COUNTS * quantum and size < most:
            size = min(10.0 * size, most)
            found = changes(port, size)
        found = {name: change / size for name, change in found.items()}
        if port == "sensor" and is_open:
            # The twin follows the recorded position: what is left of its noise in the residual.
            found = {name: -kernel for name, kernel in found.items()}
            found[str(position)] = found[str(position)] + to_si * np.eye(1, taps)[0]
        return found

    kernels = dict(zip(ports, simulations.map(one, ports), strict=True))
    own = kernels.get("torque", {})
    pushed = Pushed(own.pop(_READ), own.pop(_ACTING)) if _READ in own else None
    simulated = {p: own for p, own in kernels.items() if not (is_open and p == "sensor")}
    if "sensor" in simulated:
        kernels["sensor"] = _with_reading(simulated["sensor"], position, to_si)
    if "command" in kernels and command in kernels["command"] and not is_open:
        # What the controller commands otherwise is in the log as well.
        logged = kernels["command"][command] + np.eye(1, taps)[0]
        kernels["command"] = {**kernels["command"], command: logged}
    rounding = quantum / (np.sqrt(12.0) * to_si)
    found = PortKernels(kernels, step, simulated, pushed=pushed, rounding=rounding)
    return replace(found, is_counted=not rounded and rounding > 0.0)


def _count(response: Response, position: str | None) -> float:
    """[SI unit] In which a simulated position comes; 0 where it comes in none."""
    counted = None if position is None else response.held.get(position)
    return 0.0 if counted is None else resolution(counted)


def _changed(simulations: Simulations, after: Response, before: Response) -> dict[str, Array]:
    """Change of each signal as it is logged."""
    found = {}
    for name in before.held:
        source = "new" if name in simulations.new_rows else "held"
        found[name] = getattr(after, source)[name] - getattr(before, source)[name]
    return found


def through(columns: Array, kernel: Array) -> Array:
    """Answer of a signal to columns at a port, shape (..., n).

    Parameters
    ----------
    columns : ndarray, shape (..., n)
        From row to row.
    kernel : ndarray, shape (taps,)
        Impulse response.
    """
    n = columns.shape[-1]
    length = next_fast_len(n + kernel.size, real=True)
    spectrum = rfft(columns, length, axis=-1) * rfft(kernel, length)
    answer: Array = irfft(spectrum, length, axis=-1)[..., :n]
    return answer


def _with_reading(
    simulated: Mapping[str, Array], position: str | None, to_si: float
) -> dict[str, Array]:
    """Answers to the sensor's noise with what the log alone has of it."""
    found = dict(simulated)
    if position in found:
        found[position] = found[position] + _lacking(found[position], to_si)
    return found


def _lacking(kernel: Array, to_si: float) -> Array:
    """What the logged reading has of its own noise and the simulated one has not, shape (taps,)."""
    lacking = np.zeros_like(kernel)
    at_once, later = abs(kernel[0]) > 0.5 * to_si, abs(kernel[1]) > 0.5 * to_si
    if not at_once:
        lacking[0] = to_si
        if later:  # the reading at t_k is made before the inputs of t_k act
            lacking[1] = -to_si
    return lacking
