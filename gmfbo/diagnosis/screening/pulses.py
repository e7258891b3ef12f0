"""Passing disturbances: where the misfit of one recording differs from all the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.misfit import Blocks, chi2
from gmfbo.diagnosis.fitting.regression import Regression, joined
from gmfbo.diagnosis.screening.port_response import PortResponse
from gmfbo.diagnosis.screening.seen_from_port import fields, whitened_columns

Array = NDArray[np.float64]

LEAST_PULSE_GAIN = 30.0
"""Fall of chi2 by which the best pulse stands out of the noise: 27 was the most in 40 nulls."""

EVERY = -1
"""A pulse in all recordings, such as one that a program triggers."""

_SHORTEST_S = 0.01
_LONGEST = 3  # that many fit into a recording: what lasts longer is no passing disturbance
_DURATIONS = 64
_DURATION_NORMS = 12
_STANDS_OUT = 2.0  # times the strongest pulse elsewhere
_SHOWN = 2  # pulses of single recordings, whose time is tried in all
_SEPARATE = 4  # pulses of a recording that are compared


@dataclass(frozen=True)
class Pulse:
    """A stretch of one recording in which the misfit differs from all the rest.

    Attributes
    ----------
    record : int
        Which recording; EVERY where it comes at the same time in all.
    start, duration : float
        [s]
    gain : float
        Fall of chi2.
    """

    record: int
    start: float
    duration: float
    gain: float


def strongest_pulse(
    case: Case, regression: Regression, response: PortResponse, own: Blocks
) -> Pulse | None:
    """Strongest pulse beyond columns; None where another stretch looks like it."""
    seen = fields(case.misfit, response, regression.left(own))
    ranked = sorted(_boxes(case, response, seen), key=lambda pulse: -pulse.gain)
    shared = _shared(case, response, seen)
    before = chi2(regression.left(own))

    def measured(pulse: Pulse) -> Pulse:
        """The same with its gain beside all columns, which boxes are ranked without."""
        change = pulse_change(case, response, pulse)
        return replace(pulse, gain=before - chi2(regression.left(joined(own, change))))

    # One recording may show best when a pulse comes that all of them hold.
    of_all = (
        [] if shared is None else [shared, *(replace(p, record=EVERY) for p in ranked[:_SHOWN])]
    )
    best = max(map(measured, of_all), key=lambda pulse: pulse.gain, default=None)
    if best is not None and (not ranked or best.gain > measured(ranked[0]).gain):
        first = best
    elif not ranked or (len(ranked) > 1 and ranked[0].gain < _STANDS_OUT * ranked[1].gain):
        return None
    else:
        first = ranked[0]
    pulse = _trimmed(first, case, regression, response, own)
    with_it = joined(own, pulse_change(case, response, pulse))
    return pulse if pulse.gain > LEAST_PULSE_GAIN * regression.excess(with_it) else None


def pulse_change(case: Case, response: PortResponse, pulse: Pulse) -> Blocks:
    """Whitened change by a pulse of unit height, shape (1, n_residuals) a window."""
    columns = []
    for k, record in enumerate(case.simulations.records):
        inside = record.plan.grid - pulse.start
        on = (inside > -1e-9) & (inside < pulse.duration - 1e-9)
        on &= pulse.record in (k, EVERY)
        columns.append(np.where(on, 1.0, 0.0)[None])
    return whitened_columns(case.misfit, response, columns)


def _trimmed(
    pulse: Pulse, case: Case, regression: Regression, response: PortResponse, own: Blocks
) -> Pulse:
    """Move both ends to where the pulse explains most."""
    step = response.step
    reach = max(1, round(0.1 * pulse.duration / step))
    before = chi2(regression.left(own))
    while reach:
        tried = [pulse]
        for first, last in product((-reach, 0, reach), repeat=2):
            start, duration = pulse.start + first * step, pulse.duration + (last - first) * step
            if duration > 0.5 * step:
                moved = Pulse(pulse.record, start, duration, 0.0)
                change = pulse_change(case, response, moved)
                gain = before - chi2(regression.left(joined(own, change)))
                tried.append(Pulse(pulse.record, start, duration, gain))
        best = max(tried, key=lambda p: p.gain)
        if best.gain <= pulse.gain:
            reach //= 2
        pulse = best
    return pulse


def _shared(case: Case, response: PortResponse, seen: Sequence[Array]) -> Pulse | None:
    """Strongest pulse at the same time in all recordings; None where they begin apart."""
    grids = [record.plan.grid for record in case.simulations.records]
    if len(grids) < 2 or np.ptp([grid[0] for grid in grids]) > 0.5 * response.step:
        return None
    rows = min(len(field) for field in seen)
    sums = np.concatenate([[0.0], np.cumsum(sum(field[:rows] for field in seen))])
    shortest = max(2, round(_SHORTEST_S / response.step))
    durations = np.unique(np.round(np.geomspace(shortest, max(shortest + 1, rows // _LONGEST), 12)))
    sizes = np.sum(_box_sizes(case, response, durations.astype(int)), axis=0)
    best = Pulse(EVERY, 0.0, 0.0, 0.0)
    for n, size in zip(durations.astype(int), sizes, strict=True):
        gains = (sums[n:] - sums[:-n]) ** 2 / max(float(size), 1e-300)
        place = int(np.argmax(gains))
        if gains[place] > best.gain:
            start = float(grids[0][place])
            best = Pulse(EVERY, start, n * response.step, float(gains[place]))
    return best if best.gain > 0.0 else None


def _boxes(case: Case, response: PortResponse, seen: Sequence[Array]) -> list[Pulse]:
    """Strongest pulses of each recording that are apart from each other."""
    step = response.step
    shortest = max(2, round(_SHORTEST_S / step))
    longest = max(shortest + 1, max(len(field) for field in seen) // _LONGEST)
    durations = np.unique(np.round(np.geomspace(shortest, longest, _DURATIONS)))
    coarse = durations[:: max(1, durations.size // _DURATION_NORMS)].astype(int)
    sizes = _box_sizes(case, response, coarse)
    found: list[Pulse] = []
    for k, field in enumerate(seen):
        sums = np.concatenate([[0.0], np.cumsum(field)])
        best, lasting = np.zeros(field.size), np.zeros(field.size, dtype=int)
        for n in durations.astype(int):
            if n >= field.size:
                continue
            size = float(np.interp(n, coarse, sizes[k]))
            gains = np.zeros(field.size)
            gains[: field.size - n + 1] = (sums[n:] - sums[:-n]) ** 2 / max(size, 1e-300)
            lasting = np.where(gains > best, n, lasting)
            best = np.maximum(gains, best)
        found += _separate(k, case.simulations.records[k].plan.grid, best, lasting, step)
    return found


def _box_sizes(case: Case, response: PortResponse, durations: NDArray[np.intp]) -> list[Array]:
    """Mean square of a unit pulse's whitened change, by duration, of each recording."""
    sizes = []
    whiteners = case.misfit.whiteners
    for k, rows in enumerate(response.rows):
        places = [0.2, 0.4, 0.6, 0.8]
        columns = np.zeros((len(durations) * len(places), rows))
        for i, n in enumerate(durations):
            for j, place in enumerate(places):
                begin = int(place * rows - 0.5 * n)
                columns[i * len(places) + j, max(0, begin) : begin + n] = 1.0
        changed = response.filtered(k, columns)
        square = np.zeros(len(columns))
        for whitener in whiteners:
            if whitener.window.record == k:
                square += np.sum(whitener.whiten(changed) ** 2, axis=-1)
        sizes.append(square.reshape(len(durations), len(places)).max(axis=1))
    return sizes


def _separate(
    k: int, grid: Array, gains: Array, lasting: NDArray[np.intp], step: float
) -> list[Pulse]:
    """Strongest pulses of one recording that do not overlap."""
    gains, pulses = gains.copy(), []
    for _ in range(_SEPARATE):
        i = int(np.argmax(gains))
        if gains[i] <= 0.0:
            break
        n = int(lasting[i])
        pulses.append(Pulse(k, float(grid[i]), n * step, float(gains[i])))
        # Whatever touches the pulse or its aftermath is the same event.
        ends = np.arange(gains.size) + lasting
        gains[(np.arange(gains.size) < i + 2 * n) & (ends > i - n)] = 0.0
    return pulses
