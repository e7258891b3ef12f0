"""Row spacing of a recording against the step of its twin: a clock in another unit shows there."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.columns.columns import Column, RecordedColumns
from gmfbo.units import number, parse_unit

_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
LONGER_UNITS = {"min": 60.0, "h": 3600.0, "d": 86400.0}
"""Units above a second [s], days as of a spreadsheet; here they count only where rows lie at a
round distance in them and in no shorter one."""

MOST_STEPS = 100.0
"""Steps of a twin between two rows, beyond which the rows show nothing of what it computes.

Loggers are a tenth to ten times as fast as the twin steps; times in ms that are read as seconds
make that 100 to 10,000.
"""

_FEWEST_STEPS = 10.0
"""Steps of a twin in a whole recording, below which there is nothing to compare."""

_ROUND = 1e-4
"""Deviation from a number of two digits up to which a distance is round, as a share of it: what
rounding to 0.01 min leaves of the mean over some hundred rows. By chance 0.4 % of all are."""

FEWEST_ROWS = 64
"""Fewest rows that a recording needs; so many in so few steps are no slow logger."""


def check_spacing(file: RecordedColumns, clock: Column, name: str, step: float) -> None:
    """Raise where rows lie as far apart, or as close, as only another unit of time explains.

    A recording of many rows within one step has nothing to compare, whatever its unit.

    Parameters
    ----------
    file : RecordedColumns
        For the message.
    clock : Column
        Times as they were recorded, increasing or equal; its unit is one of time.
    name : str
        Of the clock's column in the file.
    step : float
        [s] Communication step of the twin.

    Raises
    ------
    RecordingError
        The message names the likely unit, and the line that states it.
    """
    likely = mistaken_time_unit(clock, step)
    recorded, unit = _instants(clock), parse_unit(clock.unit or "s")
    if recorded.size < 2 or unit is None:
        return
    time = unit.to_si(recorded)
    spacing, duration = float(np.median(np.diff(time))), float(time[-1] - time[0])
    close = _is_close(time, step)
    if likely is None and not (close and duration < step):
        return
    steps = round(spacing / step)
    seen = f"rows {spacing:,.9g} s apart, {steps:,} steps of the twin each"
    if close:
        seen = f"{time.size:,} rows in {number(duration / step)} steps of the twin"
    stated = clock.unit or "s"
    asked = f"is the time in {likely}?" if likely else "is the time in another unit?"
    raise file.refuse(
        f'{seen}; {asked} write time = {{ column = "{name}", unit = "{likely or "UNIT"}" }} in '
        f'[columns] of the twin file, or unit = "{stated}" there if it is right'
    )


def mistaken_time_unit(clock: Column, step: float) -> str | None:
    """Unit in which a clock probably is, where rows contradict the one that it states.

    Parameters
    ----------
    clock : Column
        Times as they were recorded, increasing or equal; seconds where it states no unit.
    step : float
        [s] Communication step of the twin.

    Returns
    -------
    str or None
        None where the stated unit may be right.
    """
    recorded = _instants(clock)
    unit = parse_unit(clock.unit or "s")
    if recorded.size < 2 or unit is None:
        return None
    time, apart = unit.to_si(recorded), float(np.median(np.diff(recorded)))
    spacing = float(np.median(np.diff(time)))
    # A step of 1 ms that was written as 0.99 ms is no other number of steps.
    if not (spacing > 1.01 * MOST_STEPS * step or _is_close(time, step)):
        return None
    mean = float(recorded[-1] - recorded[0]) / (recorded.size - 1)
    likely = _likely(apart, mean, step)
    seconds = {**_UNITS, **LONGER_UNITS}[likely]
    return None if math.isclose(spacing, apart * seconds) else likely


def is_round(distance: float) -> bool:
    """Whether a distance of rows has two digits at most, as loggers are set.

    Parameters
    ----------
    distance : float
        Positive, in any unit.
    """
    return math.isclose(distance, float(f"{distance:.1e}"), rel_tol=_ROUND)


def _instants(clock: Column) -> NDArray[np.float64]:
    """Times of the rows; rows of one instant are read as one."""
    kept: NDArray[np.bool_] = np.append(True, np.diff(clock.values) != 0.0)
    return np.asarray(clock.values[kept])


def _is_close(time: NDArray[np.float64], step: float) -> bool:
    """Whether many rows lie within a few steps."""
    return bool(time[-1] - time[0] < _FEWEST_STEPS * step and time.size >= FEWEST_ROWS)


def _likely(spacing: float, mean: float, step: float) -> str:
    """Unit of time in which a spacing is nearest to the step, by its logarithm."""
    units = dict(_UNITS)
    if not is_round(mean):
        units |= {unit: s for unit, s in LONGER_UNITS.items() if is_round(mean * s)}
    return min(units, key=lambda unit: abs(math.log(spacing * units[unit] / step)))
