"""Check recordings before any diagnosis: faults of logging, and effects that would show."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.case.fitted_starts import told_starts
from gmfbo.diagnosis.checking.contradicted_command import refuse_columns
from gmfbo.diagnosis.checking.contradicted_motion import judge_motions
from gmfbo.diagnosis.checking.empirical_response import Response, empirical_response
from gmfbo.diagnosis.checking.findings import all_findings
from gmfbo.diagnosis.checking.nominal_case import NominalCase, open_nominal
from gmfbo.diagnosis.checking.recording_facts import recording_facts
from gmfbo.diagnosis.checking.result import Check, ResponseSeen
from gmfbo.diagnosis.checking.seen_alignment import against_controller
from gmfbo.diagnosis.checking.showable_sizes import showable_sizes
from gmfbo.diagnosis.checking.two_readings import Reading, agreed, note_on, slower_inputs, straight
from gmfbo.diagnosis.naming.decision_told import units_of
from gmfbo.diagnosis.result.findings import Cost
from gmfbo.diagnosis.runs.given_recording import as_recording, on_fmu_clock
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.controlled_signal import reference_of
from gmfbo.sources.recorded.usable import usable
from gmfbo.sources.twin.twin import FmuTwin

Progress = Callable[[str, float], None]
Array = NDArray[np.float64]

_RUNS_A_RECORDING = 22  # estimate of the runs that opening a case takes, for progress only
_OPENED = 0.3  # share of the progress when the case is open
_ERRORS = 4.0  # standard deviations of a response above which the twin differs from it


def check(
    twin: FmuTwin | str | Path,
    recordings: Sequence[Recording | str | Path],
    *,
    seed: int = 0,
    progress: Progress | None = None,
    jobs: int | None = None,
) -> Check:
    """Find faults of recordings and the effects they can show, in seconds and without a fit.

    Parameters
    ----------
    twin : FmuTwin, str or Path
        The twin, or its twin file.
    recordings : sequence of Recording, str or Path
        Runs of the real axis.
    seed : int
        Of the noise that is sent through the loop.
    progress : callable (str, float), optional
        Called with the stage and the share done.
    jobs : int, optional
        Simulations at a time; one a processor unless given.

    Returns
    -------
    Check
        Findings, facts of each recording, responses, and the sizes that would show.

    Raises
    ------
    RecordingError
        A recording cannot be read, has nothing to compare, or contradicts the twin grossly.
    SimulationError
        The twin as it is cannot follow the recordings.
    """
    started = time.perf_counter()
    told = progress or (lambda stage, share: None)
    told("reading", 0.0)
    opened = twin if isinstance(twin, FmuTwin) else FmuTwin(twin)
    try:
        read, later = on_fmu_clock([as_recording(one, opened) for one in recordings], opened)
        given = usable(opened, read)
        notes = judge_motions(opened, given.recordings, given.doubts, seed=seed, jobs=jobs)
        open_gaps = slower_inputs(opened, given.recordings)
        counted = _Counted(told, _RUNS_A_RECORDING * max(1, len(read)) * (2 if open_gaps else 1))
        open_for = partial(
            open_nominal, recordings=given.recordings, seed=seed, jobs=jobs, on_run=counted.one
        )
        nominal = open_for(opened)
        nominal.case.notes[:0] = (*given.notes, *notes, *note_on(open_gaps))
        with nominal.case.simulations:
            refuse_columns(nominal.case, nominal.checked, given.doubts)
            reading = _read(nominal, later, told)
            if open_gaps:
                other = open_for(straight(opened, open_gaps))
                reading = agreed(reading, _read_beside(nominal, other, later, told))
            return _seen(nominal, reading, told, started)
    finally:
        if not isinstance(twin, FmuTwin):
            opened.close()


class _Counted:
    """Counts runs while a case is opened, and reports them as progress."""

    def __init__(self, told: Progress, expected: int) -> None:
        self._told, self._expected, self._runs = told, expected, 0

    def one(self) -> None:
        self._runs += 1
        if self._runs <= self._expected:
            self._told("running the twin as it is", _OPENED * self._runs / self._expected)


def _read(nominal: NominalCase, later: Mapping[str, float], told: Progress) -> Reading:
    case = nominal.case
    told("looking at the columns", _OPENED)
    views = against_controller(case, nominal.checked, nominal.rows)
    facts = {}
    for k, name in enumerate(_names(case)):
        view = views[k] if views else None
        own = recording_facts(case, k, view, _bandwidth(case, k))
        facts[name] = own.later_by(later.get(name, 0.0))
    return Reading(
        all_findings(case, facts, views, nominal.logged, nominal.mixed),
        facts,
        _logged(nominal),
        nominal.checked.why_not.get("controller", ""),
        _responses(case),
    )


def _read_beside(
    nominal: NominalCase, other: NominalCase, later: Mapping[str, float], told: Progress
) -> Reading:
    """Read another case and close it; its runs count as the first one's."""
    with other.case.simulations:
        reading = _read(other, later, told)
    nominal.case.simulations.runs += other.case.simulations.runs
    return reading


def _seen(nominal: NominalCase, reading: Reading, told: Progress, started: float) -> Check:
    case = nominal.case
    excited = showable_sizes(
        case,
        lambda share: told("trying the effects", _OPENED + 0.05 + (0.95 - _OPENED) * share),
    )
    told("done", 1.0)
    units = units_of(case)
    return Check(
        twin=case.twin.name,
        findings=reading.findings,
        recordings=reading.facts,
        logged=reading.logged,
        parity_why_not=reading.why_not,
        responses=reading.responses,
        showable=excited.showable,
        not_testable=excited.not_testable,
        notes=(*case.notes, *told_starts(case)),
        units={"position": units.position, "velocity": units.velocity},
        cost=Cost(case.simulations.runs, time.perf_counter() - started),
    )


def _names(case: Case) -> list[str]:
    return [record.name for record in case.simulations.records]


def _logged(nominal: NominalCase) -> dict[str, str]:
    """Logging convention by signal: the command's by parity, the others' as their file states it.

    What fits the twin's own run better is no evidence: it holds whatever the twin lacks.
    """
    outputs = nominal.case.twin.file.outputs
    told = {name: "new" for name, entry in outputs.items() if entry.logged == "new"}
    command = command_of(nominal.case)
    if command is None or nominal.mixed:
        return {name: how for name, how in told.items() if name != command}
    if nominal.logged is not None:
        told[command] = nominal.logged
    return told


def _source(case: Case) -> str | None:
    """Input that drove the recordings: the reference, or else the first input that moves."""
    inputs = [
        name
        for name in case.twin.file.inputs
        if all(name in r.plan.recording.signals for r in case.simulations.records)
    ]
    reference = reference_of(case.twin)
    if reference in inputs:
        return reference
    moving = [n for n in inputs if any(np.ptp(c) > 0.0 for c in _driven(case, n))]
    return moving[0] if moving else None


def _driven(case: Case, name: str) -> list[Array]:
    return [np.asarray(r.plan.experiment.inputs[name]) for r in case.simulations.records]


def _response(
    case: Case,
    source: str,
    signal: str,
    chosen: Sequence[int],
    simulated: Sequence[Mapping[str, Array]] | None = None,
) -> Response | None:
    """Estimate a response on each recording's own grid, on which the twin's inputs are held.

    `simulated` holds the twin's signals of each recording, at the times of the scored samples;
    without it the response is the recorded one.
    """
    xs, ys = [], []
    slowest = 0.0
    for k in chosen:
        record = case.simulations.records[k]
        grid = record.plan.grid
        for own in record.signals:
            if own.name != signal:
                continue
            slowest = max(slowest, own.spacing, _spacing(record.plan.recording, source))
            inside = (grid >= own.time[0] - 1e-9) & (grid <= own.time[-1] + 1e-9)
            column = own.values if simulated is None else simulated[k][signal]
            xs.append(np.asarray(record.plan.experiment.inputs[source])[inside])
            ys.append(np.interp(grid[inside], own.time, column))
    return empirical_response(xs, ys, case.twin.step, 0.5 / slowest) if xs else None


def _spacing(recording: Recording, name: str) -> float:
    """[s] Between the samples of a recorded column."""
    sampled = recording.time[np.isfinite(recording.signal(name))]
    return float(sampled[-1] - sampled[0]) / max(1, sampled.size - 1)


def _bandwidth(case: Case, record: int) -> float:
    """[Hz] Highest frequency at which any signal still answers the source."""
    source = _source(case)
    if source is None:
        return float("nan")
    found = [
        own.trusted[1]
        for signal in case.simulations.records[record].signals
        if (own := _response(case, source, signal.name, [record])) is not None
    ]
    known = [f for f in found if np.isfinite(f)]
    return max(known, default=float("nan"))


def _responses(case: Case) -> tuple[ResponseSeen, ...]:
    source = _source(case)
    if source is None:
        return ()
    chosen, simulated = _alike(case), _free_runs(case)
    if simulated is None:
        return ()
    seen = []
    for signal in case.twin.file.outputs:
        recorded = _response(case, source, signal, chosen)
        twin = _response(case, source, signal, chosen, simulated)
        if recorded is not None and twin is not None:
            seen.append(_response_seen(source, signal, recorded, twin))
    return tuple(seen)


def _free_runs(case: Case) -> list[dict[str, Array]] | None:
    """Signals of the twin without any correction, by recording; None where it does not run.

    An open-loop twin was opened with a loop that holds it on its recordings: it would agree
    with them whatever it lacks.
    """
    records = case.simulations.records
    if case.simulations.tracking is None:
        return [
            {own.name: values for own, values in zip(r.signals, run.signals, strict=True)}
            for r, run in zip(records, case.base.simulated, strict=True)
        ]
    runs = [case.twin.run({}, record.plan.recording) for record in records]
    case.simulations.runs += len(runs)
    if any(run.status != "ok" for run in runs):
        return None
    return [
        {own.name: np.interp(own.time, run.time, run.signal(own.name)) for own in record.signals}
        for record, run in zip(records, runs, strict=True)
    ]


def _alike(case: Case) -> list[int]:
    """Recordings with the parameters of the first one: only these share one response."""
    records = case.simulations.records
    first = records[0].plan.experiment.parameters.in_force
    return [k for k, r in enumerate(records) if r.plan.experiment.parameters.in_force == first]


def _response_seen(source: str, signal: str, recorded: Response, twin: Response) -> ResponseSeen:
    # The same reference excites both; a bin where only one answers is left out.
    _, own, other = np.intersect1d(recorded.frequency, twin.frequency, return_indices=True)
    frequency, coherence = recorded.frequency[own], recorded.coherence[own]
    value, model = recorded.value[own], twin.value[other]
    low, high = recorded.trusted
    error = np.abs(value / model - 1.0)
    told = (frequency >= low) & (frequency <= high) & (error > _ERRORS * recorded.error[own])
    apart, apart_at = 0.0, float("nan")
    if told.any():
        worst = int(np.argmax(np.where(told, error, 0.0)))
        apart, apart_at = float(error[worst]), float(frequency[worst])
    return ResponseSeen(
        source=source,
        signal=signal,
        frequency=tuple(frequency.tolist()),
        gain=tuple(np.abs(value).tolist()),
        phase=tuple(np.angle(value).tolist()),
        twin_gain=tuple(np.abs(model).tolist()),
        twin_phase=tuple(np.angle(model).tolist()),
        coherence=tuple(coherence.tolist()),
        trusted=recorded.trusted,
        apart=apart,
        apart_at=apart_at,
    )
