"""Facts of one recording: its motion, its columns and its clock."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.checking.column_quality import (
    clipped_rows,
    clock_quality,
    is_latched,
    lost_rows,
    near_rounding,
    refresh_rows,
    repeated_rows,
    usual_noise,
)
from gmfbo.diagnosis.checking.result import (
    ClockQuality,
    ColumnQuality,
    RecordingFacts,
    SeenAlignment,
)
from gmfbo.diagnosis.checking.seen_alignment import ControllerView, against_twin
from gmfbo.diagnosis.runs.measured_excitation import reversals, states_of
from gmfbo.diagnosis.runs.quantum import resolution
from gmfbo.diagnosis.runs.scored_record import LEAST_ROWS
from gmfbo.physics import States
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.controlled_signal import reference_of
from gmfbo.sources.twin.twin import FmuTwin

Array = NDArray[np.float64]

_LIMIT_NAMES = re.compile(r"(limit|max|saturation)", re.IGNORECASE)
_AT_LIMIT = 0.99  # of a limit, from which a signal counts as at it


def recording_facts(
    case: Case, record: int, view: ControllerView | None, bandwidth: float
) -> RecordingFacts:
    """Gather the facts of one recording.

    Parameters
    ----------
    case : Case
        At nominal parameters.
    record : int
        Index of the recording.
    view : ControllerView or None
        The controller's residual, where it could be checked.
    bandwidth : float
        [Hz] Of its response to the reference.
    """
    scored = case.simulations.records[record]
    recording = scored.plan.recording
    states = states_of(case.base.simulated[record], scored)
    low, high = np.quantile(_velocity(case, recording, states), [0.005, 0.995])
    recorded = _position(case, recording)
    position = states.position if recorded is None else recorded
    alignment = {
        signal.name: _against_twin(case, record, place)
        for place, signal in enumerate(scored.signals)
    }
    command = command_of(case)
    if view is not None and command is not None:
        alignment[command] = view.command
        if case.rig.position in alignment:
            alignment[case.rig.position] = view.position
    return RecordingFacts(
        duration=recording.duration,
        bandwidth=bandwidth,
        reversals=reversals(states),
        position=(float(position.min()), float(position.max())),
        speed=(float(low), float(high)),
        clock=_clock(case, recording),
        columns=_columns(case, recording, states),
        alignment=alignment,
        parity=view.excess if view is not None else math.nan,
        has_position=recorded is not None,
    )


def _against_twin(case: Case, record: int, place: int) -> SeenAlignment:
    name = case.simulations.records[record].signals[place].name
    if case.simulations.tracking is not None and name in case.rig.positions:
        # A tracking loop holds an open-loop twin on the recorded position: never late.
        return SeenAlignment("twin", math.nan, math.nan, math.nan, 0.0)
    return against_twin(case, record, place)


def _position(case: Case, recording: Recording) -> Array | None:
    name = case.rig.position
    if name is None or name not in recording.signals:
        return None
    values = recording.signal(name)
    return np.asarray(values[np.isfinite(values)] / case.rig.position_to_si, dtype=np.float64)


def _velocity(case: Case, recording: Recording, states: States) -> Array:
    """[FMU's unit] As it was recorded; that of the twin where it was not."""
    for name in _velocities(case.twin):
        if name in recording.signals:
            variable = case.twin.file.outputs[name].variable
            to_si = case.twin.binding.variables[variable].variable.to_si
            values = recording.signal(name)
            if np.isfinite(values).any():
                return np.asarray(values[np.isfinite(values)] / to_si, dtype=np.float64)
    return states.velocity


def _velocities(twin: FmuTwin) -> list[str]:
    """Outputs that are the state `velocity`."""
    wanted = twin.file.states.get("velocity")
    return [name for name, e in twin.file.outputs.items() if e.variable == wanted]


def _named(case: Case, recording: Recording) -> list[str]:
    """Signals that the twin reads or is compared with."""
    file = case.twin.file
    return [n for n in (*file.inputs, *file.outputs) if n in recording.signals]


def _clock(case: Case, recording: Recording) -> ClockQuality:
    names = _named(case, recording)
    known = {n: np.isfinite(recording.signal(n)) for n in names}
    # Where columns have rates of their own, the fastest tells of the clock.
    rows = max(known.values(), key=lambda mask: int(mask.sum()))
    full = [n for n in names if known[n][rows].all()]
    positions = _told(recording, [n for n in full if n in case.rig.positions], rows)
    others = _told(recording, [n for n in full if n == reference_of(case.twin)], rows)
    return clock_quality(recording.time[rows], lost_rows(positions, others))


def _told(recording: Recording, names: Sequence[str], rows: NDArray[np.bool_]) -> list[Array]:
    """Columns with a new sample in every row: a latched or coarse column jumps all the time."""
    found = []
    for name in names:
        values = recording.signal(name)[rows]
        if not is_latched(refresh_rows(values, resolution(values))):
            found.append(values)
    return found


def _columns(case: Case, recording: Recording, states: States) -> dict[str, ColumnQuality]:
    command = command_of(case)
    return {
        name: _quality(case, recording, name, states, is_command=name == command)
        for name in _named(case, recording)
        if np.isfinite(recording.signal(name)).sum() >= LEAST_ROWS
    }


def _quality(
    case: Case, recording: Recording, name: str, states: States, *, is_command: bool
) -> ColumnQuality:
    column = recording.signal(name)
    known = np.flatnonzero(np.isfinite(column))
    values = column[known]
    quantum = resolution(values)
    is_output = name in case.twin.file.outputs
    refresh = refresh_rows(values, quantum)
    repeated = clipped = 0
    limit = _known_limit(case.twin, name, is_command=is_command) if is_output else None
    # An input may hold its value as long as it was asked to.
    if is_output and not is_latched(refresh):
        repeated = _repeated(case.twin, case.rig.positions, recording, name, known, quantum).size
        # An end stop holds a position at rest, a limit anything else while the axis accelerates.
        speed = np.interp(recording.time[known], states.time, states.velocity)
        is_position = name in case.rig.positions
        own = None if is_position else speed
        clipped = clipped_rows(values, quantum, own, is_position=is_position)
    places = np.diff(known)
    usual = np.median(places)
    extent = float(np.ptp(values))
    return ColumnQuality(
        unit=_unit(case, name),
        rows=values.size,
        resolution=quantum,
        steps=extent / quantum if quantum else float("inf"),
        noise=usual_noise(values),
        low=float(values.min()),
        high=float(values.max()),
        repeated=int(repeated),
        refresh=refresh,
        blank=int(np.sum(np.round(places / usual).clip(1.0) - 1.0)),
        clipped=clipped / values.size,
        limit=None if limit is None else limit.size,
        limit_from="" if limit is None else limit.source,
        at_limit=0.0 if limit is None else float(np.mean(np.abs(values) >= _AT_LIMIT * limit.size)),
    )


def missed_samples(
    twin: FmuTwin, positions: Collection[str], recording: Recording, name: str
) -> NDArray[np.int64]:
    """Rows in which an output, of these positions or another, repeats the row before as it moves.

    A column that is sampled more slowly than it is logged has none.
    """
    known = np.flatnonzero(np.isfinite(recording.signal(name)))
    values = recording.signal(name)[known]
    quantum = resolution(values)
    if is_latched(refresh_rows(values, quantum)):
        return known[:0]
    return _repeated(twin, positions, recording, name, known, quantum)


def _repeated(
    twin: FmuTwin,
    positions: Collection[str],
    recording: Recording,
    name: str,
    known: NDArray[np.int64],
    quantum: float,
) -> NDArray[np.int64]:
    """The same of a column that is not latched, from its known rows and its resolution."""
    values, times = recording.signal(name)[known], recording.time[known]
    rounded = np.zeros(times.size, dtype=bool)
    # Near a reading that repeats by its rounding, so may what is computed from it.
    for reading in _readings(twin, positions, name):
        if reading in recording.signals:
            own = np.flatnonzero(np.isfinite(recording.signal(reading)))
            read, rows = recording.signal(reading)[own], recording.time[own]
            asked = _asked(twin, recording, rows)
            rounded |= near_rounding(times, rows, read, resolution(read), asked)
    return known[repeated_rows(values, quantum, rounded)]


def _asked(twin: FmuTwin, recording: Recording, times: Array) -> Array | None:
    """Recorded reference at these times [s]; None where none was recorded."""
    name = reference_of(twin)
    if name is None or name not in recording.signals:
        return None
    known = np.isfinite(recording.signal(name))
    asked = np.interp(times, recording.time[known], recording.signal(name)[known])
    return np.asarray(asked, dtype=np.float64)


def _readings(twin: FmuTwin, positions: Collection[str], name: str) -> list[str]:
    """A command is computed from the position or the velocity, a velocity from the position."""
    if name in positions:
        return []
    velocities = _velocities(twin)
    return [*positions] if name in velocities else [*positions, *velocities]


def _unit(case: Case, name: str) -> str:
    file = case.twin.file
    variable = (file.outputs[name] if name in file.outputs else file.inputs[name]).variable
    return case.twin.binding.variables[variable].variable.si_unit


class _KnownLimit(NamedTuple):
    """Size [SI] that a signal does not exceed in the twin, and what says so."""

    size: float
    source: str


def _known_limit(twin: FmuTwin, signal: str, *, is_command: bool) -> _KnownLimit | None:
    """Find the limit that a twin states for one of its [outputs]; None where it states none.

    For a command, a parameter that is called a limit and has the same unit counts as well.
    """
    binding = twin.binding
    name = twin.file.outputs[signal].variable
    variable = binding.variables[name].variable
    ends = [abs(end) for end in (variable.minimum, variable.maximum) if end is not None]
    if ends and max(ends) > 0.0:
        return _KnownLimit(max(ends) * variable.to_si, name)
    if not is_command:
        return None
    found = []
    for other, bound in binding.variables.items():
        own = bound.variable
        if own.causality != "parameter" or own.value_type is None:
            continue
        last = other.rpartition(".")[2]
        if own.si_unit and own.si_unit == variable.si_unit and _LIMIT_NAMES.search(last):
            value = twin.nominal(other) * own.to_si
            if value > 0.0:
                found.append(_KnownLimit(value, other))
    return min(found, key=lambda limit: limit.size, default=None)
