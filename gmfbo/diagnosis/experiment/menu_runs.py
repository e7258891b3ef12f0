"""Simulate the menu's patterns in place of the recordings, and compare rivals on them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.experiment.reference_menu import MenuEntry, RecordedLimits, reference_menu
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.runs.scored_record import Record, ScoredSignal
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.scoring.noise_levels import tolerance_covariance, white_covariance
from gmfbo.diagnosis.scoring.nuisances import record_directions
from gmfbo.diagnosis.scoring.whitening import Whitener, make_window
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

_MOVES = 0.99  # of a reference's power lies below its bandwidth
_JUMP = 20.0  # times the fastest motion: a faster change in one sample is a step


def reference_input(case: Case) -> str | None:
    """Input that the controller follows: in the position's unit or in none; None where none is."""
    if case.simulations.tracking is not None or case.rig.position is None:
        return None
    binding = case.twin.binding
    inputs, outputs = binding.file.inputs, binding.file.outputs
    unit = binding.variables[outputs[case.rig.position].variable].variable.si_unit
    alike = [
        name
        for name, entry in inputs.items()
        if binding.variables[entry.variable].variable.si_unit in (unit, "", "1")
    ]
    held = [n for n in alike if n in case.simulations.records[0].plan.recording.signals]
    return "reference" if "reference" in held else next(iter(held), None)


def recorded_limits(case: Case, base: Fitted, reference: str) -> RecordedLimits:
    """Range, speed, acceleration and bandwidth of what was recorded.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    base : Fitted
        Model that moves like the recordings; replayed encoder noise is left out.
    reference : str
        Input that the controller follows.
    """
    speeds, accelerations, bands, columns = [], [], [], []
    simulated = base.simulated
    for record, run in zip(case.simulations.records, simulated, strict=True):
        grid = record.plan.grid
        velocity = np.gradient(run.response.held[case.rig.position or ""], grid)
        speeds.append(float(np.quantile(np.abs(velocity), 0.995)))
        accelerations.append(float(np.quantile(np.abs(np.gradient(velocity, grid)), 0.99)))
        column = record.plan.experiment.inputs[reference]
        columns.append(column)
        bands.append(_bandwidth(column, grid))
    speed = max(speeds)
    first = case.simulations.records[0].plan.grid
    spacing = float(first[1] - first[0])
    return RecordedLimits(
        start=float(columns[0][0]),
        low=min(float(c.min()) for c in columns),
        high=max(float(c.max()) for c in columns),
        speed=speed,
        acceleration=max(accelerations),
        bandwidth=max(bands),
        duration=case.setting.excitation.duration,
        step=_largest_step(columns, _JUMP * speed * spacing),
        spacing=spacing,
    )


def _bandwidth(column: NDArray[np.float64], grid: NDArray[np.float64]) -> float:
    """Frequency [Hz] below which a reference has almost all of its power."""
    power = np.abs(np.fft.rfft((column - column.mean()) * np.hanning(column.size))) ** 2
    total = np.cumsum(power)
    place = int(np.searchsorted(total, _MOVES * total[-1])) + 1
    return place / float(grid[-1] - grid[0])


def _largest_step(columns: Sequence[NDArray[np.float64]], least: float) -> float:
    """Largest jump within one sample from where the reference starts; 0 where there is none."""
    jumps = np.concatenate([np.diff(column) for column in columns])
    largest = float(jumps[int(np.argmax(np.abs(jumps)))])
    start = float(columns[0][0])
    inside = min(c.min() for c in columns) <= start + largest <= max(c.max() for c in columns)
    return largest if abs(largest) > least and inside else 0.0


def make_menu(
    case: Case, base: Fitted, reference: str
) -> tuple[tuple[MenuEntry, ...], tuple[Record, ...]]:
    """Lay the patterns that are safe for this axis on the communication grid.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    base : Fitted
        The model that moves like the recordings; limits are read from it.
    reference : str
        Input that the controller follows.

    Returns
    -------
    tuple
        Patterns, and each as a record of the recorded signals, all zero.
    """
    limits = recorded_limits(case, base, reference)
    if limits.stroke <= 0.0 or limits.speed <= 0.0 or limits.acceleration <= 0.0:
        return (), ()
    entries, like = reference_menu(limits), case.simulations.records[0]
    recordings = [_as_recording(case, like, reference, entry, limits) for entry in entries]
    return entries, as_records(case, recordings)


def joined(records: Sequence[Record], plays: Sequence[int], name: str) -> Recording:
    """Inputs of some records one after the other, as a recording of that name."""
    parts = [records[place].plan.recording for place in plays]
    first = parts[0]
    signals = {key: np.concatenate([part.signals[key] for part in parts]) for key in first.signals}
    rows = sum(part.time.size for part in parts)
    time = np.arange(rows, dtype=np.float64) * (first.time[1] - first.time[0])
    return replace(first, time=time, signals=signals, name=name)


def _as_recording(
    case: Case, like: Record, reference: str, entry: MenuEntry, limits: RecordedLimits
) -> Recording:
    time = np.arange(entry.values.size, dtype=np.float64) * limits.spacing
    signals = {
        name: entry.values if name == reference else np.full(time.size, column[0])
        for name, column in like.plan.experiment.inputs.items()
    }
    binding = case.twin.binding
    units = {
        name: binding.variables[binding.file.inputs[name].variable].variable.si_unit
        for name in signals
    }
    return Recording(
        time=time,
        signals=signals,
        units=units,
        name=f"{entry.name}.csv",
        parameters=like.plan.recording.parameters,
    )


def as_records(case: Case, references: Sequence[Recording]) -> tuple[Record, ...]:
    """References as if the signals of the recordings had been recorded along them, all zero."""
    like = case.simulations.records[0]
    with AugmentedTwin(case.twin, substeps=case.substeps) as simulator:
        return tuple(_as_record(simulator, like, recording) for recording in references)


def _as_record(simulator: AugmentedTwin, like: Record, recording: Recording) -> Record:
    plan = simulator.plan(recording, {})
    start, end = float(recording.time[0]), float(recording.time[-1])
    signals = []
    for signal in like.signals:
        rows = int((end - start) / signal.spacing) + 1
        time = start + signal.spacing * np.arange(rows, dtype=np.float64)
        signals.append(ScoredSignal(signal.name, time, np.zeros(rows), signal.resolution))
    return Record(recording.name, plan, tuple(signals), start, end)


@contextmanager
def playing(case: Case, records: tuple[Record, ...]) -> Iterator[None]:
    """Let the simulators of a case play something else for a while."""
    recorded = case.simulations.records
    case.simulations.replace_records(records)
    try:
        yield
    finally:
        case.simulations.replace_records(recorded)


@dataclass(frozen=True, eq=False)
class Played:
    """A rival on the menu.

    Attributes
    ----------
    simulated : list of Simulated
        One an entry.
    columns : list
        Change of the signals per unit of each free parameter, as in `Fitted`.
    """

    simulated: list[Simulated]
    columns: list[list[tuple[NDArray[np.float64], ...]]]


def play(case: Case, rival: Fitted) -> Played | None:
    """Simulate the menu that `case` plays now under a rival; None where a run ends early."""
    hypothesis = rival.hypothesis
    simulated = case.simulations.run([hypothesis.point(rival.x)])[0]
    if not all(run.finite for run in simulated):
        return None
    unscored = Misfit(case.simulations, ())
    columns = unscored.sensitivities(
        hypothesis, rival.x, simulated, range(rival.x.size), parallel=True
    )
    return Played(simulated, columns)


def whitener_of(case: Case, entry: int, simulated: Simulated) -> Whitener:
    """Whitener of one pattern that plays now, by noise, tolerance and the nuisances of a rig."""
    record = case.simulations.records[entry]
    rows = [slice(0, s.values.size) for s in record.signals]
    window = make_window(entry, [s.spacing for s in record.signals], rows)
    values = zip(record.signals, simulated.signals, strict=True)
    seen = replace(record, signals=tuple(replace(s, values=v) for s, v in values))
    variances = [case.noise[s.name].total ** 2 for s in record.signals]
    covariance = white_covariance(window, variances)
    covariance = covariance + tolerance_covariance(window, seen, case.rig.positions)
    own = record_directions(record, simulated, case.rig.alignments)
    return Whitener(window, covariance).without(own)
