"""A clock that is read in a wrong unit of time, by how the twin moves on either.

Rows that lie closer than usual are a fast logger's, or in minutes; those far apart a slow one's,
or in ms: the simulation decides. Where the spacing of rows alone leaves no doubt, the reader
refuses them before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gmfbo.errors import RecordingError
from gmfbo.plain_words import percent
from gmfbo.recordings.columns.row_spacing import (
    FEWEST_ROWS,
    LONGER_UNITS,
    MOST_STEPS,
    is_round,
)
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.recorded.controlled_signal import controlled
from gmfbo.sources.recorded.motion_unit import MUCH_BETTER, is_met, is_unlike, mean_error
from gmfbo.sources.twin.twin import FmuTwin

_TIMES_LONGER = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9, "s": 1e3, **LONGER_UNITS}
"""How many times longer a recording is in a unit than as it was read: in s, or where it is in s,
in ms."""

_USUAL = (0.01, 10.0)
"""Steps of a twin between two rows of usual loggers; beyond, other units are tried."""


@dataclass(frozen=True)
class ClockUnit:
    """Another unit of a recording's clock, in which the twin meets the recording far better.

    Attributes
    ----------
    unit : str
        One of time, such as `min`.
    error, stated : float
        Mean NRMSE of the compared signals in that unit, and as it was read [1]; infinite where the
        twin did not run to the end.
    column : str
        Of the clock, where the twin file names it.
    """

    unit: str
    error: float
    stated: float
    column: str = "COLUMN"

    def told(self, name: str) -> str:
        """Say it in one line, for a recording of this name."""
        before = percent(self.stated) if math.isfinite(self.stated) else "no run to the end"
        return (
            f"{name}: the time seems to be in {self.unit}: read so, the twin's mean error is "
            f'{percent(self.error)}, not {before}; write time = {{ column = "{self.column}", '
            f'unit = "{self.unit}" }} in [columns] of the twin file, or unit = "s" there if it is '
            "right"
        )


def clock_unit(twin: FmuTwin, recording: Recording, run: Trajectory) -> ClockUnit | None:
    """Find the unit of time in which a recording leaves less than half of the twin's error.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recording : Recording
        As it was read.
    run : Trajectory
        The twin along it.

    Returns
    -------
    ClockUnit or None
        None where the twin file states the unit, where gmfbo wrote the file, and where the
        simulated signals have the shape and size of the recorded ones.
    """
    mapping = twin.column_mapping()
    if recording.written_by or mapping.states_time or len(recording) < FEWEST_ROWS:
        return None
    clock = mapping.columns.get("time")
    column = "COLUMN" if clock is None else clock.column
    units = [unit for unit in _TIMES_LONGER if _may_be_in(twin, recording, unit)]
    if not units or (run.status == "ok" and not is_unlike(twin, recording, run)):
        return None
    stated = mean_error(twin, recording, run)
    best, least = None, MUCH_BETTER * stated
    for unit in units:
        other = replace(recording, time=_TIMES_LONGER[unit] * recording.time, use=None)
        try:
            along = twin.run({}, other)
        except RecordingError:  # it would take more steps than a run may
            continue
        error = mean_error(twin, other, along)
        if error < least and is_met(twin, other, along, controlled(twin)):
            best, least = ClockUnit(unit, error, stated, column), error
    return best


def _may_be_in(twin: FmuTwin, recording: Recording, unit: str) -> bool:
    """Whether rows would lie at a usual distance, and lie at an unusual one as they were read.

    Unusual is a distance of many steps, one closer than the twin steps, or one that is round in
    the other unit alone.
    """
    longer = _TIMES_LONGER[unit]
    steps = float(np.median(np.diff(recording.time))) / twin.step
    if longer < 1.0:
        return steps > _USUAL[1] and longer * steps >= _USUAL[0]
    mean = recording.duration / (len(recording) - 1)
    if is_round(longer * mean) and not is_round(mean):
        return longer * steps <= MOST_STEPS
    # A step of 1 ms that was written as 0.99 ms is no fast logger's.
    return steps < 1.0 / 1.02 and longer * steps <= _USUAL[1]
