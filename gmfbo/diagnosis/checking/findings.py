"""Faults of recordings in words, each with its cure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.checking.alignment_findings import of_alignment
from gmfbo.diagnosis.checking.column_quality import clipped_rows, is_latched, misses_samples
from gmfbo.diagnosis.checking.result import (
    ClockQuality,
    ColumnQuality,
    Finding,
    RecordingFacts,
)
from gmfbo.diagnosis.checking.seen_alignment import ControllerView
from gmfbo.diagnosis.scoring.noise_levels import POSITION_TOLERANCE, TOLERANCE
from gmfbo.plain_words import listed, number, percent, quantity
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.missing_signals import missing_signals
from gmfbo.sources.recorded.still_signals import CURE, still_signals

_BLANK_SHARE = 1e-3
_CLIPPED_SHARE = 3e-3
_JITTER = 0.05  # of a step; beyond 0.1 the reader notes how such a recording is followed
_COARSE = 3.0 * math.sqrt(12.0)  # quanta: rounding is three times what the diagnosis tolerates
_SPOILING = {"still_column", "lost_rows", "repeated_samples", "latched_column", "clipped_column"}
_UNJUDGED = "late or scaled columns of this recording, and its controller, were not judged"

# Worst first: what makes everything after it wrong.
_ORDER = (
    "missing_column",
    "still_column",
    "lost_rows",
    "repeated_samples",
    "latched_column",
    "logger_convention",
    "mixed_conventions",
    "shifted_column",
    "scaled_column",
    "offset_column",
    "controller_gain",
    "controller_parity",
    "clipped_column",
    "held_before",
    "no_reversal",
    "coarse_column",
    "jitter",
    "blank_samples",
)


def all_findings(
    case: Case,
    facts: Mapping[str, RecordingFacts],
    views: Sequence[ControllerView],
    logged: str | None,
    mixed: Mapping[str, Sequence[str]],
) -> tuple[Finding, ...]:
    """Findings of all kinds, worst first.

    Parameters
    ----------
    case : Case
        At nominal parameters.
    facts : mapping of str to RecordingFacts
        By recording.
    views : sequence of ControllerView
        One a recording; empty where the controller could not be checked.
    logged : str or None
        Convention of the command's column by the controller's parity.
    mixed : mapping of str to sequence of str
        Recordings that hold the `held` and the `new` command, where they differ; else empty.
    """
    found = [*_missing(case), *_conventions(case, logged), *_mixed(case, mixed)]
    for k, (name, own) in enumerate(facts.items()):
        faults = [*_still(case, k, name), *_of_clock(name, own.clock)]
        for signal, quality in own.columns.items():
            faults += _of_column(case, k, name, signal, quality)
        spoiling = next((i for i, one in enumerate(faults) if one.kind in _SPOILING), None)
        if spoiling is None:
            faults += of_alignment(case, name, own, views[k] if views else None)
        else:
            # A spoiled column also seems late or scaled.
            one = faults[spoiling]
            faults[spoiling] = replace(one, cure=f"{one.cure}; then check again: {_UNJUDGED}")
        found += faults
    if not any(own.reversals for own in facts.values()):
        found.append(
            Finding(
                "no_reversal",
                "",
                "",
                "the axis never turns back: friction and a constant torque look alike, a gap does "
                "not show",
                "add a recording that moves to and fro",
            )
        )
    return tuple(sorted(found, key=lambda finding: _ORDER.index(finding.kind)))


def _missing(case: Case) -> list[Finding]:
    recordings = [record.plan.recording for record in case.simulations.records]
    return [
        Finding(
            "missing_column",
            own.recording,
            own.signal,
            f"{own.what}: {own.without}",
            f"record it, or map its column (gmfbo columns ... --set {own.signal}=COLUMN)",
        )
        for own in missing_signals(case.twin, recordings)
    ]


def _still(case: Case, record: int, name: str) -> list[Finding]:
    recording = case.simulations.records[record].plan.recording
    found = still_signals(case.twin, recording)
    return [Finding("still_column", name, signal, what, CURE) for signal, what in found.items()]


def _conventions(case: Case, logged: str | None) -> list[Finding]:
    command = command_of(case)
    if logged is None or command is None:
        return []
    stated = case.twin.file.outputs[command].logged
    if stated in ("unknown", logged):
        return []
    return [
        Finding(
            "logger_convention",
            "",
            command,
            f'the twin file says logged = "{stated}", but the column holds the '
            f"{'command just computed' if logged == 'new' else 'command still held'}",
            f'write logged = "{logged}" for {command}',
        )
    ]


def _mixed(case: Case, mixed: Mapping[str, Sequence[str]]) -> list[Finding]:
    command = command_of(case)
    if not mixed or command is None:
        return []
    held, new = (listed(mixed[which]) for which in ("held", "new"))
    return [
        Finding(
            "mixed_conventions",
            "",
            command,
            f"each row holds the command still in force in {held}, but the command just computed "
            f"in {new}",
            "log all recordings alike, or diagnose each kind by itself, with its own "
            f'logged = "held" or "new" for {command} in the twin file',
        )
    ]


def _of_clock(name: str, clock: ClockQuality) -> list[Finding]:
    found = []
    if clock.lost_by_clock:
        found.append(
            Finding(
                "lost_rows",
                name,
                "",
                f"{clock.lost_by_clock} rows are missing by the clock",
                "log without losses, or cut the recording there (# use = FROM:TO)",
            )
        )
    if clock.lost_at:
        shown = ", ".join(number(t, 4) for t in clock.lost_at[:3])
        more = " ..." if len(clock.lost_at) > 3 else ""
        found.append(
            Finding(
                "lost_rows",
                name,
                "",
                f"all signals jump at {shown}{more} s, as if rows were lost, but the times go on "
                "evenly",
                "log the drive's own time, or score a stretch without jumps (# use = FROM:TO)",
            )
        )
    if clock.jitter > _JITTER:
        found.append(
            Finding(
                "jitter",
                name,
                "",
                f"steps of the clock are off by up to {percent(clock.jitter)}",
                "log the time at which the drive sampled, not that of the computer",
            )
        )
    return found


def _of_column(
    case: Case, record: int, name: str, signal: str, quality: ColumnQuality
) -> list[Finding]:
    is_output = signal in case.twin.file.outputs
    found = []

    def add(kind: str, what: str, cure: str) -> None:
        found.append(Finding(kind, name, signal, what, cure))

    if is_output and is_latched(quality.refresh):
        add(
            "latched_column",
            f"holds each value for {number(quality.refresh, 2)} rows",
            "log it at its own rate, or leave the repeated cells blank",
        )
    if misses_samples(quality.repeated, quality.rows):
        add(
            "repeated_samples",
            f"{quality.repeated} of {quality.rows} rows repeat the one before while it moves",
            "find out why the logger misses samples; leave those cells blank",
        )
    blank = _blank(case.simulations.records[record].plan.recording, quality)
    if blank:
        samples = "1 sample is" if blank == 1 else f"{blank} samples are"
        add(
            "blank_samples",
            f"{samples} blank beyond its own rate",
            "log without losses; what is blank is not scored or is interpolated",
        )
    if is_output and quality.resolution:
        tolerance = POSITION_TOLERANCE if signal in case.rig.positions else TOLERANCE
        if quality.steps < 1.0 / (_COARSE * tolerance):
            add(
                "coarse_column",
                f"has {quality.steps:.0f} steps of "
                f"{quantity(quality.resolution, quality.unit)} within its range",
                "log it with more digits or move farther; smaller errors do not show",
            )
    if quality.clipped > _CLIPPED_SHARE and not _twin_clips(case, record, signal):
        limit = ""
        if quality.limit is not None:
            limit = f"; the twin allows {quantity(quality.limit, quality.unit)}"
        largest = max(abs(quality.low), abs(quality.high))
        add(
            "clipped_column",
            f"stays at its extreme, {quantity(largest, quality.unit)}, for "
            f"{percent(quality.clipped)} of the rows{limit}",
            "check the logger's range and the drive's limit, or move less",
        )
    return found


def _blank(recording: Recording, quality: ColumnQuality) -> int:
    """Samples of a column to be told as blank; rows that are blank throughout are lost rows."""
    if quality.rows + quality.blank < len(recording):
        # It has a rate of its own, by which few blank cells may be counted wrongly.
        return quality.blank if quality.blank > _BLANK_SHARE * quality.rows else 0
    empty = np.isnan([*recording.signals.values()]).all(axis=0)
    return max(0, quality.blank - int(empty.sum()))


def _twin_clips(case: Case, record: int, signal: str) -> bool:
    simulated = case.base.simulated[record].response.held.get(signal)
    if simulated is None:
        return False
    return clipped_rows(simulated, 0.0) > _CLIPPED_SHARE * simulated.size
