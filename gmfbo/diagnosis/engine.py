"""Diagnose a twin from recordings: all steps in their order."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gmfbo.diagnosis.case.case import Case, times_noise
from gmfbo.diagnosis.case.open_case import open_case, open_unseen
from gmfbo.diagnosis.case.wider_ranges import wider_ranges
from gmfbo.diagnosis.checking.between_rows import (
    a_row_sooner,
    driven_as_likelier,
    note_of_straight,
    straight_inputs,
)
from gmfbo.diagnosis.checking.consistent_recordings import consistent
from gmfbo.diagnosis.checking.shown_gains import find_shown_gain
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.locating.parities import logged_as, parities
from gmfbo.diagnosis.result.whereabouts import TimeWindow
from gmfbo.diagnosis.runs.exciting_pieces import exciting_pieces
from gmfbo.diagnosis.runs.given_recording import as_recording, on_fmu_clock
from gmfbo.diagnosis.screening.exclusion import Excluded, check_assumed, excluded
from gmfbo.diagnosis.stage_times import Progress, StageTimes
from gmfbo.diagnosis.steps import Search
from gmfbo.errors import InputError
from gmfbo.physics import CATALOGUE, Effect
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.description import read_description
from gmfbo.sources.fmu_file.models import physics_fmu
from gmfbo.sources.twin.twin import FmuTwin


def diagnose(
    twin: FmuTwin | str | Path,
    recordings: Sequence[Recording | str | Path],
    validate: Sequence[Recording | str | Path] | None = None,
    *,
    seed: int = 0,
    assume: Sequence[str] = (),
    exclude: Sequence[str] = (),
    progress: Progress | None = None,
    jobs: int | None = None,
) -> Diagnosis:
    """Find out why a twin and recordings of the real axis differ.

    Parameters
    ----------
    twin : FmuTwin, str or Path
        The twin, or its twin file.
    recordings : sequence of Recording, str or Path
        Runs of the real axis.
    validate : sequence of Recording, str or Path, optional
        Runs that are only scored; without them, part of `recordings` is held out.
    seed : int
        Seed of all random draws.
    assume : sequence of str
        Effects that are tested even where the recordings seem not to show them.
    exclude : sequence of str
        Effects never named, and parameters of the twin to hold: names or shell patterns.
    progress : callable (str, float), optional
        Called with the stage and the share done.
    jobs : int, optional
        Simulations at a time; one a processor unless given.

    Returns
    -------
    Diagnosis
        The missing physics, its place, and the fit with it.

    Raises
    ------
    InputError
        An effect or parameter has no such name, or the law of an added effect is missing.
    RecordingError
        A recording cannot be read, has nothing to compare, or contradicts the twin grossly.
    SimulationError
        The twin as it is cannot follow the recordings.
    """
    started, told = time.perf_counter(), StageTimes(progress or _silent, "reading")
    opened = twin if isinstance(twin, FmuTwin) else FmuTwin(twin)
    ruled_out = _checked(opened, assume, exclude)
    read, later, notes = _compared(recordings, opened)
    unseen, more = on_fmu_clock([as_recording(one, opened) for one in validate or ()], opened)
    told("running the twin", 0.0)
    with ExitStack() as closing:
        closing.enter_context(nullcontext() if opened is twin else opened)
        cases = _cases(ruled_out.held_in(opened), read, unseen, seed, jobs, closing)
        cases.seen.notes.extend(notes)
        search = Search(cases.seen, np.random.default_rng(seed), assume, ruled_out, told)
        found = search.diagnosis(seed, started, cases.unseen)
    cost = replace(found.cost, stages=told.seconds)
    return _by_own_clocks(replace(found, cost=cost, not_compared=cases.not_compared), later | more)


def _compared(
    recordings: Sequence[Recording | str | Path], twin: FmuTwin
) -> tuple[list[Recording], dict[str, float], list[str]]:
    """What is compared, on the FMU's clock; what gives their own clock back; and notes."""
    pieces, notes = exciting_pieces([as_recording(one, twin) for one in recordings], twin)
    return *on_fmu_clock(pieces, twin), notes


def _by_own_clocks(found: Diagnosis, later: Mapping[str, float]) -> Diagnosis:
    """Tell times of recordings by their own clocks, which may begin later than the FMU's."""
    if not later:
        return found
    times = tuple(
        TimeWindow(one.recording, *(t + later.get(one.recording, 0.0) for t in one[1:]))
        for one in found.location.times
    )
    curves = tuple(
        replace(one, time=one.time + later.get(one.recording, 0.0)) for one in found.curves
    )
    return replace(found, location=replace(found.location, times=times), curves=curves)


def _silent(stage: str, share: float) -> None:
    """Show no progress."""


@dataclass(frozen=True, eq=False)
class _Cases:
    seen: Case
    unseen: Case | None
    not_compared: tuple[str, ...]


def _cases(
    twin: FmuTwin,
    recordings: Sequence[Recording],
    unseen: Sequence[Recording],
    seed: int,
    jobs: int | None,
    closing: ExitStack,
) -> _Cases:
    """Open a case of each kind of recordings, under the gain that the drive really had."""
    closing.enter_context(twin.keeping_workers())
    given = consistent(twin, recordings, seed=seed, jobs=jobs)
    held_out = consistent(twin, unseen, seed=seed, jobs=jobs)
    missing = (*given.missing, *held_out.missing)
    recordings, unseen = given.recordings, held_out.recordings
    gain = find_shown_gain(twin, recordings, seed=seed, jobs=jobs)
    if gain is not None:
        recordings, unseen = gain.put_in(recordings), gain.put_in(unseen)
    driven = driven_as_likelier(
        _aligned_case(twin, recordings, seed, jobs),
        recordings,
        lambda other, own: _aligned_case(other, own, seed, jobs),
    )
    unseen = a_row_sooner(unseen, driven.late)
    case = _with_ranges_that_hold(driven.case, driven.recordings, seed, jobs)
    case.notes.extend(note_of_straight(straight_inputs(case.twin, twin), driven.late))
    closing.callback(case.simulations.close)
    case.notes.extend(dict.fromkeys((*given.notes, *held_out.notes)))
    case.notes.extend(
        dict.fromkeys(
            f"{m.recording}: {m.what}: {m.without}; gmfbo columns maps it" for m in missing
        )
    )
    not_compared = tuple(dict.fromkeys(f"{m.signal} ({m.recording}: {m.what})" for m in missing))
    if gain is not None:
        case.notes.append(gain.note)
    if not unseen:
        return _Cases(case, None, not_compared)
    other = open_unseen(case, unseen, seed=seed, jobs=jobs)
    closing.callback(other.simulations.close)
    return _Cases(case, other, not_compared)


def _aligned_case(
    twin: FmuTwin, recordings: Sequence[Recording], seed: int, jobs: int | None
) -> Case:
    """Open a case; open it anew if the controller's parity shows the other logging convention."""
    case = open_case(twin, recordings, seed=seed, jobs=jobs)
    command = twin.file.states.get("command")
    unknown = {
        name
        for name, entry in twin.file.outputs.items()
        if entry.logged == "unknown" and entry.variable == command
    }
    if not unknown or all(recording.written_by for recording in recordings):
        return case
    try:
        decided = logged_as(parities(case, case.base))
    except BaseException:
        case.simulations.close()
        raise
    rows = case.simulations.new_rows
    right = rows | unknown if decided == "new" else rows - unknown
    if decided is None or right == rows:
        return case
    case.simulations.close()
    return open_case(twin, recordings, seed=seed, jobs=jobs, new_rows=right)


def _with_ranges_that_hold(
    case: Case, recordings: Sequence[Recording], seed: int, jobs: int | None
) -> Case:
    """Open a case anew with wider ranges, where these explain what the twin file's own do not."""
    try:
        wider = wider_ranges(case)
        if wider is None:
            return case
        rows = case.simulations.new_rows
        again = open_case(case.twin, recordings, seed=seed, jobs=jobs, new_rows=rows, wider=wider)
    except BaseException:
        case.simulations.close()
        raise
    better, worse = (again, case) if _leaves_less(again, case) else (case, again)
    better.simulations.runs += worse.simulations.runs
    worse.simulations.close()
    return better


def _leaves_less(one: Case, other: Case) -> bool:
    return times_noise(one, one.base) < times_noise(other, other.base)


def _checked(twin: FmuTwin, assume: Sequence[str], exclude: Sequence[str]) -> Excluded:
    """Look names and laws up, before the work instead of after it."""
    check_assumed(twin.binding, assume)
    _check_laws(CATALOGUE.added)
    return excluded(twin.binding, exclude)


def _check_laws(added: Sequence[Effect]) -> None:
    """Raise unless the user's physics.fmu holds the law of each added effect."""
    if not added:
        return
    path = physics_fmu()
    known = read_description(path).variables
    for effect in added:
        for parameter in effect.parameters:
            name = f"{effect.name}.{parameter.name}"
            if name not in known:
                raise InputError(
                    f"effect '{effect.name}': expected its law in '{path}', which has no parameter "
                    f"'{name}'; build it in, and name that file in GMFBO_PHYSICS"
                )
