"""Coordinates along which lines of a misfit may stand: the position, and time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.diagnosis.screening.port_response import PortResponse, between_points
from gmfbo.physics import States

Array = NDArray[np.float64]

TOP_FREQUENCY = 100.0
"""[Hz] At which a line may pass by; a loop hides faster torques."""

_LEAST_CYCLES = 0.7  # within a stroke of less than a turn
_LEAST_REPEATS = 2.0  # in a slide's stroke or the longest recording: fewer are offset and slope
_SAMPLES_A_CYCLE = 3.0
_SLOW_PART = 0.5  # of the motion
_OVERSAMPLING = 4  # points of the scan within the resolution of one cycle in the range
_MOST_SCANNED = 4000


@dataclass(frozen=True, eq=False)
class Axis:
    """A coordinate, and the places on it at which lines are looked for.

    Attributes
    ----------
    phases : tuple of ndarray, shape (rows,)
        [rad per unit of place] Of a line along each recording.
    rates : tuple of ndarray, shape (rows,)
        [rad per unit of place] By which they change in a step.
    places : ndarray, shape (n_places,)
        [rad per position unit] or [Hz] Evenly spaced.
    resolution : float
        Distance at which two lines can be told apart without noise.
    rounded : bool
        Whole numbers are likely, as cycles in a turn.
    sizes : tuple of ndarray, shape (rows,), optional
        Share of its amplitude that a line has along each recording, -1 to 1; 1 unless given.
    """

    phases: tuple[Array, ...]
    rates: tuple[Array, ...]
    places: Array
    resolution: float
    rounded: bool
    sizes: tuple[Array, ...] | None = None

    def waves(self, places: Array) -> list[Array]:
        """Sines, then cosines of lines: one array a recording of shape (2 * n_places, rows)."""
        columns = []
        for k, (phase, rate) in enumerate(zip(self.phases, self.rates, strict=True)):
            turned = np.outer(places, phase)
            # Where a line passes too fast for the samples, they would show another one.
            visible = np.outer(places, rate) < 2.0 * np.pi / _SAMPLES_A_CYCLE
            sizes = visible if self.sizes is None else visible * self.sizes[k]
            columns.append(np.concatenate([np.sin(turned) * sizes, np.cos(turned) * sizes]))
        return columns

    def sums(self, fields_at_port: Sequence[Array]) -> NDArray[np.complex128]:
        """Sum of field times exp(i place phase) over each recording, (n_records, n_places)."""
        out = np.empty((len(self.phases), self.places.size), dtype=complex)
        step = self.places[1] - self.places[0] if self.places.size > 1 else 0.0
        for k, (phase, rate, field) in enumerate(
            zip(self.phases, self.rates, fields_at_port, strict=True)
        ):
            if self.sizes is not None:
                field = field * self.sizes[k]
            moving = np.flatnonzero(field)
            turning = field[moving] * np.exp(1j * self.places[0] * phase[moving])
            turn = np.exp(1j * step * phase[moving])
            limits = 2.0 * np.pi / _SAMPLES_A_CYCLE / np.maximum(rate[moving], 1e-300)
            for i, place in enumerate(self.places):
                out[k, i] = turning[limits > place].sum()
                turning *= turn
        return out


def over_position(case: Case, base: Fitted, response: PortResponse) -> Axis | None:
    """Wavenumbers that the motion can show; None where it does not move."""
    excitation = case.setting.excitation
    records = case.simulations.records
    states = [states_of(run, record) for run, record in zip(base.simulated, records, strict=True)]
    speed = _slow_speed(states)
    cycles = _LEAST_CYCLES if excitation.angular else _LEAST_REPEATS
    least = 2.0 * np.pi * cycles / excitation.stroke
    most = 2.0 * np.pi * min(TOP_FREQUENCY, 1.0 / (_SAMPLES_A_CYCLE * response.step)) / speed
    most = min(most, 2.0 * np.pi / (_SAMPLES_A_CYCLE * excitation.resolution))
    if not np.isfinite(most) or most <= least:
        return None
    resolution = 2.0 * np.pi / excitation.stroke
    phases = tuple(between_points(s.position) for s in states)
    rates = tuple(np.abs(s.velocity) * response.step for s in states)
    return Axis(phases, rates, _places(least, most, resolution), resolution, excitation.angular)


def with_current(axis: Axis, case: Case, base: Fitted) -> Axis | None:
    """Let the lines of an axis grow with the current; None where there is none.

    Lines that turn their sign with the current leave no plain line in a motion to and fro.
    """
    records = case.simulations.records
    currents = [
        np.asarray(states_of(run, record).current)
        for run, record in zip(base.simulated, records, strict=True)
    ]
    largest = max(float(np.abs(current).max()) for current in currents)
    if largest <= 0.0:
        return None
    return replace(axis, sizes=tuple(current / largest for current in currents))


def _slow_speed(states: Sequence[States]) -> float:
    """Speed below which a part of the motion stays that can show a line."""
    moving = np.concatenate([np.abs(s.velocity[np.abs(s.velocity) > s.rest]) for s in states])
    return float(np.quantile(moving, _SLOW_PART)) if moving.size else np.inf


def over_time(case: Case) -> Axis | None:
    excitation = case.setting.excitation
    records = case.simulations.records
    grids = [record.plan.grid for record in records]
    step = float(grids[0][1] - grids[0][0])
    resolution = 1.0 / excitation.duration
    least = _LEAST_REPEATS * resolution
    most = min(TOP_FREQUENCY, 1.0 / (_SAMPLES_A_CYCLE * step))
    if most <= least:
        return None
    phases = tuple(2.0 * np.pi * (grid + 0.5 * step) for grid in grids)
    rates = tuple(np.full(grid.size, 2.0 * np.pi * step) for grid in grids)
    return Axis(phases, rates, _places(least, most, resolution), resolution, False)


def _places(least: float, most: float, resolution: float) -> Array:
    count = int(_OVERSAMPLING * (most - least) / resolution) + 2
    places: Array = np.linspace(least, most, min(count, _MOST_SCANNED))
    return places
