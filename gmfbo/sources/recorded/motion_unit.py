"""Reference and measured motion that are both in one other unit than the twin takes them in.

In such a recording the axis still follows its reference. Its command tells: it belongs to a motion
of another size, and a twin whose command has a limit is at that limit nearly all the time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from gmfbo.errors import GmfboError
from gmfbo.objective.fit import nrmse
from gmfbo.plain_words import listed, percent
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.recorded.controlled_signal import (
    controlled,
    reference_of,
    seen_signal,
    unit_of,
)
from gmfbo.sources.recorded.likeness import SAME_SHAPE, Likeness
from gmfbo.sources.recorded.mistaken_unit import known_units, times_si
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.units import parse_unit

MUCH_BETTER = 0.5
"""Share of the error in SI below which another unit is believed. A right unit leaves what physics
is missing; the nearest wrong one, degrees for radians, is off by a factor of 57."""


_LARGEST_EFFECT = 10.0
"""Factor by which the library's largest effects change a command; a unit has to differ by more
where no controller tells the two apart."""


@dataclass(frozen=True, eq=False)
class MotionUnit:
    """Another unit of a recording's motion, in which the twin meets the recording far better.

    Attributes
    ----------
    unit : str
        Of the controlled signal and its reference.
    names : tuple of str
        Signals that are in it, or that per second.
    recording : Recording
        Read in that unit, in SI.
    error, stated : float
        Mean NRMSE of the compared signals in that unit, and as the recording was read [1];
        infinite where the twin did not run to the end.
    """

    unit: str
    names: tuple[str, ...]
    recording: Recording
    error: float
    stated: float

    @property
    def is_beyond_physics(self) -> bool:
        """Whether no effect of the library changes a command by as much as this unit."""
        return abs(math.log(times_si(self.unit))) > math.log(_LARGEST_EFFECT)

    def told(self, name: str) -> str:
        """Say it in one line, for a recording of this name."""
        before = percent(self.stated) if math.isfinite(self.stated) else "no run to the end"
        return (
            f"{name}: {listed(self.names)} seem to be in {self.unit}: read so, the twin's mean "
            f"error is {percent(self.error)}, not {before}; {self.cure()}"
        )

    def cure(self) -> str:
        """Say how to state the unit."""
        return (
            f'write unit = "{self.unit}" for them in [columns] of the twin file, or '
            f'"{self.names[-1]} [{self.unit}]" in the header'
        )


def motion_unit(twin: FmuTwin, recording: Recording, run: Trajectory) -> MotionUnit | None:
    """Find the unit in which a recording's motion leaves less than half of the twin's error.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recording : Recording
        As it was read, in SI.
    run : Trajectory
        The twin along it.

    Returns
    -------
    MotionUnit or None
        None in open loop, and where no compared signal is far from the simulated one.
    """
    signal = controlled(twin)
    if not signal or not {reference_of(twin), signal} <= recording.signals.keys():
        return None
    if run.status == "ok" and not is_unlike(twin, recording, run):
        return None
    stated = mean_error(twin, recording, run)
    best, least = None, MUCH_BETTER * stated
    si = unit_of(twin, signal)
    for unit in known_units(si):
        if unit == f"k{si}":
            continue  # no logger counts a motion in thousands of radians or of metres
        for names in _motions(twin, recording, signal):
            changed = {name: recording.signal(name) / times_si(unit) for name in names}
            other = recording.with_signals(changed)
            along = twin.run({}, other)
            error = mean_error(twin, other, along)
            if error < least and is_met(twin, other, along, signal):
                best, least = MotionUnit(unit, names, other, error, stated), error
    return best


def mean_error(twin: FmuTwin, recording: Recording, run: Trajectory) -> float:
    """Mean NRMSE of the compared signals [1]; infinite where the run did not reach its end.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recording : Recording
        What is compared.
    run : Trajectory
        The twin along it.
    """
    if run.status != "ok":
        return math.inf
    errors = []
    for name in twin.file.outputs:
        if name in recording.signals:
            try:
                errors.append(nrmse(run, recording, name, warmup=twin.file.warmup or 0.0))
            except GmfboError:  # it never moves, so that its range is zero
                continue
    return sum(errors) / len(errors) if errors else math.inf


def is_unlike(twin: FmuTwin, recording: Recording, run: Recording) -> bool:
    """Whether a compared signal has another shape or size than the simulated one.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recording : Recording
        What is compared.
    run : Recording
        The twin along it, to its end.
    """
    seen = _all_seen(twin, recording, run)
    return any(one.correlation < SAME_SHAPE or one.is_far_in_size for one in seen)


def is_met(twin: FmuTwin, recording: Recording, run: Trajectory, signal: str) -> bool:
    """Whether the controlled signal is followed in shape, and all compared ones in size.

    A motion that is made too small leaves little error too.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recording : Recording
        What is compared.
    run : Trajectory
        The twin along it.
    signal : str
        Controlled signal; empty in open loop, where each compared one has to have the shape.
    """
    if run.status != "ok":
        return False
    every = _all_seen(twin, recording, run)
    held = seen_signal(twin, recording, signal, run) if signal in recording.signals else None
    shapes = every if held is None else [held]
    if not shapes or any(one.correlation < SAME_SHAPE for one in shapes):
        return False
    return not any(one.is_far_in_size for one in every)


def _all_seen(twin: FmuTwin, recording: Recording, run: Recording) -> list[Likeness]:
    compared = [name for name in twin.file.outputs if name in recording.signals]
    seen = [seen_signal(twin, recording, name, run) for name in compared]
    return [one for one in seen if one is not None]


def _motions(twin: FmuTwin, recording: Recording, signal: str) -> Iterator[tuple[str, ...]]:
    """Signals that share the unit of the controlled one; then with those in it per second."""
    way = parse_unit(unit_of(twin, signal))
    assert way is not None, "only a known unit has others of its kind"
    rate = parse_unit(f"{way.si}/s")
    alike, moving = [], []
    for name, entry in {**twin.file.inputs, **twin.file.outputs}.items():
        own = parse_unit(twin.binding.variables[entry.variable].variable.si_unit or "1")
        if name not in recording.signals or own is None:
            continue
        if own.dimension == way.dimension:
            alike.append(name)
        elif rate is not None and own.dimension == rate.dimension:
            moving.append(name)
    yield tuple(alike)
    if moving:
        yield (*moving, *alike)
