"""Simulate logs with a first twin, and let the simulation settle units that no file states."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gmfbo.errors import GmfboError, RecordingError, SimulationError
from gmfbo.objective.fit import nrmse
from gmfbo.recordings.columns.column_guesses import quantity_of_unit
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.reference import step_reference
from gmfbo.sources.first_twin.log_columns import LogColumns
from gmfbo.sources.first_twin.signals import Signals
from gmfbo.sources.first_twin.twin_text import twin_text
from gmfbo.sources.fmu_file.job import STOP_TIME_LINE
from gmfbo.sources.recorded.contradiction import contradiction
from gmfbo.sources.recorded.missing_signals import missing_signals
from gmfbo.sources.recorded.motion_unit import MUCH_BETTER
from gmfbo.sources.recorded.still_signals import still_lines
from gmfbo.sources.recorded.wrapped_angle import unwrapped
from gmfbo.sources.twin.twin import FmuTwin

_OTHER_UNITS = {
    "rad": {"position": "deg", "velocity": "deg/s"},
    "m": {"position": "mm", "velocity": "mm/s"},
}
"""Units in which loggers leave out the unit, beside SI: those of drives' set points."""

_LONGEST_S = 8.0
_SETTLED = 0.02
"""Band about the last value, as a share of the step; as in the settling time of a study."""


@dataclass(frozen=True, eq=False)
class TriedLog:
    """A log and the twin's run along it.

    Attributes
    ----------
    recording : Recording
        As the twin file reads it, angles unwrapped.
    run : Trajectory
        The twin along it.
    errors : mapping of str to float
        NRMSE by compared signal [1].
    doubts : tuple of str
        What the log contradicts, lacks or was read by; a line each.
    """

    recording: Recording
    run: Trajectory
    errors: Mapping[str, float]
    doubts: tuple[str, ...]


def tried_in_likely_units(
    signals: Signals, log: LogColumns, paths: Sequence[Path]
) -> tuple[Signals, LogColumns, tuple[TriedLog, ...]]:
    """Settle units that no file states, and simulate each log.

    Parameters
    ----------
    signals : Signals
        Of the FMU.
    log : LogColumns
        How logs are read.
    paths : sequence of Path
        Logs of the same logger.

    Returns
    -------
    tuple of Signals, LogColumns and tuple of TriedLog
        Signals, which now know of an FMU that wants the end of a run announced; how logs are
        read; and the runs.

    Raises
    ------
    RecordingError
        A log cannot be read so.
    SimulationError
        The FMU failed.
    """
    likely = with_likely_units(signals, log)
    try:
        return signals, likely, tried(signals, likely, paths)
    except SimulationError as error:
        if signals.ends_announced or STOP_TIME_LINE not in str(error):
            raise
    return tried_in_likely_units(replace(signals, ends_announced=True), log, paths)


def tried(signals: Signals, log: LogColumns, paths: Sequence[Path]) -> tuple[TriedLog, ...]:
    """Simulate each log once.

    Parameters
    ----------
    signals : Signals
        Of the FMU.
    log : LogColumns
        How logs are read.
    paths : sequence of Path
        Logs of the same logger.

    Raises
    ------
    RecordingError
        A log cannot be read so.
    SimulationError
        The FMU failed.
    """
    with (
        tempfile.TemporaryDirectory(prefix="gmfbo-init-") as folder,
        FmuTwin(_written(signals, log, Path(folder))) as source,
    ):
        return tuple(_tried(source, path) for path in paths)


def with_likely_units(signals: Signals, log: LogColumns) -> LogColumns:
    """Units of motions for which neither the log nor the user states one, by simulation.

    All of them are taken to be in SI, or all in deg or mm: the controlled signal follows its
    reference in either, but the command only fits in the right one.

    Parameters
    ----------
    signals : Signals
        Of the FMU.
    log : LogColumns
        How the log is read.
    """
    unstated = [name for name in log.mapping.columns if _is_unstated_motion(signals, log, name)]
    if not unstated:
        return log
    best, least = log, MUCH_BETTER * _error(signals, log)
    for base, units in _OTHER_UNITS.items():
        other, changed = log, False
        for name in unstated:
            si = signals.known[name].variable.si_unit
            if si in (base, f"{base}/s"):
                entry = replace(log.mapping.columns[name], unit=units[quantity_of_unit(si)])
                why = f"no unit stated, {entry.unit} fits best"
                other, changed = other.with_entry(name, entry, why), True
        if changed and (error := _error(signals, other)) < least:
            best, least = other, error
    return best


def _is_unstated_motion(signals: Signals, log: LogColumns, name: str) -> bool:
    signal = signals.known.get(name)
    if signal is None or log.unit(name) or log.mapping.columns[name].scale is not None:
        return False
    return quantity_of_unit(signal.variable.si_unit) in ("position", "velocity")


def _error(signals: Signals, log: LogColumns) -> float:
    """Mean error of the compared signals [1]; infinite where there is no simulation."""
    try:
        (seen,) = tried(signals, log, [log.path])
    except (SimulationError, RecordingError):
        return math.inf
    errors = [error for error in seen.errors.values() if math.isfinite(error)]
    return sum(errors) / len(errors) if errors else math.inf


def _written(signals: Signals, log: LogColumns, folder: Path) -> Path:
    path = folder / "twin.toml"
    fmu = signals.report.path.resolve().as_posix()
    path.write_text(twin_text(signals, log, fmu), encoding="utf-8")
    return path


def _tried(source: FmuTwin, path: Path) -> TriedLog:
    recording, notes = unwrapped(Recording.read(path, source), source)
    run = source.run({}, recording)
    if run.status != "ok":
        raise SimulationError(f"{path.name}: {run.message}")
    compared = [name for name in source.file.outputs if name in recording.signals]
    missing = [f"{m.recording}: {m.what}" for m in missing_signals(source, [recording])]
    doubts = [*recording.notes, *notes, *missing, *still_lines(source, recording)]
    doubts.append(contradiction(source, recording, run))
    return TriedLog(
        recording,
        run,
        {name: _nrmse(run, recording, name, source.file.warmup or 0.0) for name in compared},
        tuple(doubt for doubt in doubts if doubt),
    )


def _nrmse(run: Trajectory, recording: Recording, name: str, warmup: float) -> float:
    try:
        return nrmse(run, recording, name, warmup=warmup)
    except GmfboError:
        return math.nan  # it never moves, so that its range is zero


def settled_after(signals: Signals, log: LogColumns, height: float) -> float:
    """Time [s] in which the twin answers a step, of 1, 2, 4 and 8 s.

    Parameters
    ----------
    signals : Signals
        Of the FMU, in closed loop.
    log : LogColumns
        How logs are read.
    height : float
        Height of the step [unit].

    Returns
    -------
    float
        The shortest one in whose second half the answer keeps within 2 % of the step; else 8.
    """
    answer = signals.controlled
    assert answer is not None, "a closed loop"
    unit = signals.known["reference"].variable.si_unit
    with (
        tempfile.TemporaryDirectory(prefix="gmfbo-init-") as folder,
        FmuTwin(_written(signals, log, Path(folder))) as source,
    ):
        step = step_reference(
            height, at=0.0, horizon=_LONGEST_S, sample_time=source.step, unit=unit
        )
        run = source.run({}, step)
    if run.status != "ok" or answer.name not in run.signals:
        return 1.0
    away = np.abs(run.signal(answer.name) - run.signal(answer.name)[-1]) > _SETTLED * abs(height)
    last = float(run.time[np.flatnonzero(away)[-1]]) if away.any() else 0.0
    return next((s for s in (1.0, 2.0, 4.0) if last <= 0.5 * s), _LONGEST_S)
