"""Recordings that contradict their twin so grossly that no missing physics can be the cause.

In a closed loop the controlled signal follows its reference, whatever physics the twin lacks: with
the largest effects of the library its gain against the simulation stays between 0.6 and 1.3. A
gain of -1, or of 57.3, or a motion that has nothing of the reference's, is a wrong column. The
command may be anything that the plant asks for; it is judged by the twin's controller on the
recorded measurement, where no plant takes part.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.plain_words import number
from gmfbo.recordings.columns.unit_in_name import note_on_header
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.recorded.clock_unit import clock_unit
from gmfbo.sources.recorded.controlled_signal import (
    controlled,
    reference_of,
    seen_signal,
    unit_of,
)
from gmfbo.sources.recorded.likeness import SAME_SHAPE, Likeness
from gmfbo.sources.recorded.mistaken_unit import AXIS_GAIN, mistaken_unit, times_si
from gmfbo.sources.recorded.motion_unit import MotionUnit, motion_unit
from gmfbo.sources.recorded.range_ends import at_range_ends, explains
from gmfbo.sources.recorded.still_signals import still_signals
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.units import parse_unit


@dataclass(frozen=True)
class Doubts:
    """Recordings that the twin's controller has to judge, by their indices.

    Attributes
    ----------
    position : frozenset of int
        Those in which the controlled signal hardly follows its reference, or never moves.
    command : frozenset of int
        Those whose command is of opposite sign, or far in size, from the simulated one.
    motion : mapping of int to MotionUnit
        Those whose reference and controlled signal fit far better in another unit.
    otherwise : mapping of int to str
        Contradictions of these, in one line each, that hold if they are in no other unit.
    """

    position: frozenset[int]
    command: frozenset[int]
    motion: Mapping[int, MotionUnit] = field(default_factory=dict)
    otherwise: Mapping[int, str] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.position or self.command or self.motion)


def refuse_contradictions(twin: FmuTwin, recordings: Sequence[Recording]) -> Doubts:
    """Compare the controlled signal of each recording with the twin as it is.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recordings : sequence of Recording
        Runs of the real axis.

    Returns
    -------
    Doubts
        Recordings for `refuse_columns` and `judge_motions`.

    Raises
    ------
    RecordingError
        A controlled signal contradicts the twin at each end of every uncertain range, or the
        clock seems to be in minutes or hours.
    """
    signal = controlled(twin)
    position, command = set(), set()
    motion, otherwise = {}, {}
    for k, recording in enumerate(recordings if signal else ()):
        if reference_of(twin) not in recording.signals:
            continue
        run = twin.run({}, recording)
        clock = clock_unit(twin, recording, run)
        if clock is not None:
            raise RecordingError(clock.told(recording.name or "recording"))
        moved = motion_unit(twin, recording, run)
        if moved is not None:
            motion[k] = moved
        if run.status != "ok":
            continue
        try:
            _refuse_motions(twin, recording, run, signal)
        except RecordingError as error:
            if moved is None:
                raise
            otherwise[k] = str(error)
        seen = seen_signal(twin, recording, signal, run) if signal in recording.signals else None
        is_still = signal in still_signals(twin, recording)
        if is_still or (seen is not None and seen.may_be_unrelated):
            position.add(k)
        if _is_doubtful(twin, recording, run):
            command.add(k)
    return Doubts(frozenset(position), frozenset(command), motion, otherwise)


def contradiction(twin: FmuTwin, recording: Recording, run: Trajectory) -> str:
    """Say how a recording contradicts the twin as it is, in one line; empty where it does not.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recording : Recording
        Run of the real axis.
    run : Trajectory
        The twin along it.
    """
    signal = controlled(twin)
    clock = clock_unit(twin, recording, run)
    if clock is not None:
        return clock.told(recording.name or "recording")
    if not signal:
        return "; ".join(_off_scales(twin, recording, run))
    moved = motion_unit(twin, recording, run)
    if moved is not None and moved.is_beyond_physics:
        return moved.told(recording.name or "recording")
    try:
        if reference_of(twin) in recording.signals:
            _refuse_motions(twin, recording, run, signal)
    except RecordingError as error:
        return str(error)
    return ""


def scale_doubts(twin: FmuTwin, recording: Recording) -> list[str]:
    """Columns of an open-loop twin that seem to be in another unit, or of opposite sign.

    Physics decides how far an axis moves that no loop holds, so nothing is refused.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recording : Recording
        Run of the real axis.

    Returns
    -------
    list of str
        A line each, with the setting that mends it.
    """
    if controlled(twin) or not twin.file.outputs.keys() & recording.signals.keys():
        return []
    run = twin.run({}, recording)
    clock = clock_unit(twin, recording, run)
    if clock is not None:
        return [clock.told(recording.name or "recording")]
    return _off_scales(twin, recording, run) if run.status == "ok" else []


def _off_scales(twin: FmuTwin, recording: Recording, run: Recording) -> list[str]:
    doubts = []
    for name in twin.file.outputs:
        if name not in recording.signals:
            continue
        told = _off_scale(twin, recording, run, name)
        if told and not _is_scaled_by_range(twin, recording, run, name):
            doubts.append(f"{told}; or a parameter is off by as much")
    return doubts


def _refuse_motions(twin: FmuTwin, recording: Recording, run: Recording, signal: str) -> None:
    """Raise where the controlled signal, or another motion, contradicts the run."""
    if signal in recording.signals:
        told = _contradicts(twin, recording, run, signal)
        if told and not _may_follow(twin, recording, run, signal):
            raise RecordingError(told)
    _refuse_other_motions(twin, recording, run, signal)


def _refuse_other_motions(twin: FmuTwin, recording: Recording, run: Recording, signal: str) -> None:
    """Raise for another motion in a wrong unit, a velocity say, where the controlled one is right.

    Forces are left out: they may be anything that the plant asks for.
    """
    seen = seen_signal(twin, recording, signal, run) if signal in recording.signals else None
    if seen is not None and (seen.correlation < SAME_SHAPE or _wrong_unit(twin, signal, seen)):
        return
    way = parse_unit(unit_of(twin, signal))
    for name in twin.file.outputs:
        own = parse_unit(unit_of(twin, name))
        if name == signal or name not in recording.signals or own is None or way is None:
            continue
        rate = parse_unit(f"{way.si}/s")
        if own.dimension not in (way.dimension, rate and rate.dimension):
            continue
        told = _off_scale(twin, recording, run, name)
        if told and not _is_scaled_by_range(twin, recording, run, name):
            raise RecordingError(told)


def _off_scale(twin: FmuTwin, recording: Recording, run: Recording, signal: str) -> str:
    """Say that a signal has the simulation's shape in another unit or sign; empty otherwise."""
    name, seen = recording.name or "recording", seen_signal(twin, recording, signal, run)
    if seen is None:
        return ""
    path = _way(run, signal)
    if seen.is_flipped and _in_both_halves(
        twin, recording, run, signal, lambda s: s.is_flipped, path
    ):
        return flipped(name, signal, "the simulation", seen.gain)
    if told := _two_units(twin, recording, run, signal, path):
        return told
    unit = _wrong_unit(twin, signal, seen)
    if unit is not None and _in_both_halves(
        twin, recording, run, signal, lambda s: _wrong_unit(twin, signal, s) == unit, path
    ):
        return in_unit(name, signal, "the simulation", seen.gain, unit)
    return ""


def _two_units(
    twin: FmuTwin,
    recording: Recording,
    run: Recording,
    signal: str,
    path: NDArray[np.float64] | None,
) -> str:
    """Say that a signal is off in the twin file's unit, where the header says another one."""
    note = note_on_header(recording.notes, signal)
    if not note or not _in_both_halves(twin, recording, run, signal, _is_off, path):
        return ""
    seen = seen_signal(twin, recording, signal, run)
    return f"{note}: it is {number(seen.gain)} times the simulation" if seen else ""


def _is_off(seen: Likeness) -> bool:
    return seen.correlation >= SAME_SHAPE and abs(math.log(seen.gain)) > math.log(AXIS_GAIN)


def _contradicts(twin: FmuTwin, recording: Recording, run: Recording, signal: str) -> str:
    """What is wrong with the controlled signal, in one line; empty where nothing is."""
    name, reference = recording.name or "recording", reference_of(twin)
    against = f"what the twin makes of {reference}"
    seen = seen_signal(twin, recording, signal, run)
    asked = seen_signal(twin, recording, signal, recording, reference)
    if seen is None or asked is None:
        return ""
    if seen.is_flipped and _in_both_halves(twin, recording, run, signal, lambda s: s.is_flipped):
        return flipped(name, signal, against, seen.gain)
    if told := _two_units(twin, recording, run, signal, None):
        return told
    unit = _wrong_unit(twin, signal, seen)
    if unit is not None and _in_both_halves(
        twin, recording, run, signal, lambda s: _wrong_unit(twin, signal, s) == unit
    ):
        return in_unit(name, signal, against, seen.gain, unit)
    unit = mistaken_unit(unit_of(twin, signal), 1.0 / asked.gain)
    if (
        unit is not None
        and asked.correlation >= SAME_SHAPE
        and _is_asked_in(twin, recording, signal, unit)
    ):
        return in_unit(name, reference, f"what {signal} follows", 1.0 / asked.gain, unit)
    if seen.is_unrelated and asked.is_unrelated:
        share = number(100.0 * max(seen.shifted, 0.0) ** 2, 2)
        return unrelated(
            name, signal, reference, f"the simulation explains {share} % of its motion at best"
        )
    return ""


def _wrong_unit(twin: FmuTwin, signal: str, seen: Likeness) -> str | None:
    if seen.correlation < SAME_SHAPE:
        return None
    return mistaken_unit(unit_of(twin, signal), seen.gain)


def _in_both_halves(
    twin: FmuTwin,
    recording: Recording,
    run: Recording,
    signal: str,
    holds: Callable[[Likeness], bool],
    path: NDArray[np.float64] | None = None,
) -> bool:
    """Whether it holds in both halves of the motion: a column is in one unit all the time.

    An axis that becomes unstable may differ by as much, but only in the end.
    """
    if path is None:
        steps = np.abs(np.diff(recording.signal(reference_of(twin))))
        if not steps.size or steps.max() > 0.5 * steps.sum():
            path = _way(run, signal)  # one step: what follows it moves, the reference does not
    if path is None:
        path = np.cumsum(steps)
        middle = int(np.searchsorted(path, 0.5 * path[-1])) + 1
        halves = (np.arange(len(recording)) < middle, np.arange(len(recording)) >= middle)
    else:
        half = run.time[int(np.searchsorted(path, 0.5 * path[-1]))]
        halves = (recording.time < half, recording.time >= half)
    seen = [seen_signal(twin, recording, signal, run, rows=half) for half in halves]
    return all(one is not None and holds(one) for one in seen)


def _way(run: Recording, signal: str) -> NDArray[np.float64]:
    """How far a signal has gone up and down until each row."""
    return np.cumsum(np.abs(np.diff(run.signal(signal), prepend=run.signal(signal)[:1])))


def _is_asked_in(twin: FmuTwin, recording: Recording, signal: str, unit: str) -> bool:
    """Whether the twin makes what was recorded of a reference that is read in another unit."""
    reference = reference_of(twin)
    converted = recording.signal(reference) / times_si(unit)
    asked = recording.with_signals({reference: converted})
    run = twin.run({}, asked)
    if run.status != "ok":
        return False
    seen = seen_signal(twin, asked, signal, run)
    return (
        seen is not None
        and seen.correlation >= SAME_SHAPE
        and mistaken_unit(unit_of(twin, signal), seen.gain) is None
        and _in_both_halves(
            twin, asked, run, signal, lambda s: _wrong_unit(twin, signal, s) is None
        )
    )


def _may_follow(twin: FmuTwin, recording: Recording, run: Recording, signal: str) -> bool:
    """Whether an uncertain parameter at an end of its range makes the contradiction go away."""
    seen = seen_signal(twin, recording, signal, run)
    return any(
        explains(seen_signal(twin, recording, signal, end), seen)
        and not _contradicts(twin, recording, end, signal)
        for end in at_range_ends(twin, recording)
    )


def _is_scaled_by_range(twin: FmuTwin, recording: Recording, run: Recording, signal: str) -> bool:
    """Whether an end of an uncertain range brings the size most of the way, or turns the sign."""
    seen = seen_signal(twin, recording, signal, run)
    return seen is not None and any(
        explains(seen_signal(twin, recording, signal, end), seen)
        for end in at_range_ends(twin, recording)
    )


def _is_doubtful(twin: FmuTwin, recording: Recording, run: Recording) -> bool:
    """Whether the command is of opposite sign or far in size: then the cut loop has to tell."""
    state = twin.file.states.get("command")
    for name, entry in twin.file.outputs.items():
        if entry.variable == state and name in recording.signals and controlled(twin):
            seen = seen_signal(twin, recording, name, run)
            if seen is not None:
                return seen.correlation < 0.0 or seen.is_far_in_size
    return False


def flipped(name: str, signal: str, against: str, gain: float) -> str:
    return (
        f"{name}: {signal} has the opposite sign of {against} (gain {number(gain)}); write "
        f"scale = -1 for {signal} in the twin file, or correct the column"
    )


def in_unit(name: str, signal: str, against: str, gain: float, unit: str) -> str:
    return (
        f"{name}: {signal} is {number(gain)} times {against}, as if it were in {unit}; write "
        f'unit = "{unit}" for {signal} in [columns] of the twin file, or "{signal} [{unit}]" in '
        "the header"
    )


def unrelated(name: str, signal: str, reference: str, why: str) -> str:
    return (
        f"{name}: {signal} does not follow {reference}, {why}; are these columns of one axis and "
        "one run? record both together, or map the right columns"
    )
