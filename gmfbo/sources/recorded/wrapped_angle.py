"""Angles that a logger wraps into one turn: their jumps by a full turn are no motion."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.controlled_signal import reference_of
from gmfbo.sources.twin.twin import FmuTwin

Array = NDArray[np.float64]

_SLACK = 1e-6  # of a turn: the last digit of a logger's text
_GOES_ON = 2.0  # times the largest other step: an unwrapped angle moves on as it did


def unwrapped(recording: Recording, twin: FmuTwin) -> tuple[Recording, tuple[str, ...]]:
    """Undo the wrapping of angles, unless the twin wraps them as well.

    A reference is unwrapped only beside a position: alone, it may have been asked to jump.
    `wrapped` in an entry of the twin file decides instead.

    Parameters
    ----------
    recording : Recording
        As it was read, in SI.
    twin : FmuTwin
        Tells which signals are angles.

    Returns
    -------
    tuple of Recording and tuple of str
        The recording, and a note for each signal that was unwrapped.
    """
    changed = _whole_angles(recording, twin, _units(twin))
    label = recording.name or "recording"
    notes = tuple(
        f"{label}: {n} jumps by a full turn: it wraps; unwrapped"
        for n in changed
        if not np.array_equal(changed[n], recording.signal(n), equal_nan=True)
    )
    return (recording.with_signals(changed) if changed else recording), notes


def _whole_angles(recording: Recording, twin: FmuTwin, units: dict[str, str]) -> dict[str, Array]:
    """Signals that wrap, without their jumps; outputs begin in the turn of their reference."""
    file = twin.file
    stated = {n: e.wrapped for n, e in (file.inputs | file.outputs).items()}
    forced = {
        name: _without_any_jump(recording.signal(name), units[name])
        for name, wraps in stated.items()
        if wraps and np.isfinite(recording.signals.get(name, np.nan)).any()
    }
    seen = {
        name: whole
        for name, unit in units.items()
        if name in recording.signals and unit in ("rad", "") and stated[name] is None
        if (whole := without_jumps(recording.signal(name), unit)) is not None
    }
    outputs = {name: whole for name, whole in seen.items() if name in file.outputs}
    if outputs and _wraps_itself(twin, recording, outputs, units):
        outputs = {}
    changed = outputs | forced
    if any(name in file.outputs for name in changed):
        changed |= {name: whole for name, whole in seen.items() if name in file.inputs}
    for name in [n for n in changed if n in file.outputs]:
        start = _start(recording, changed, units, (reference_of(twin), name))
        if start is not None:
            turn = _turn(recording.signal(name), units[name])
            own = changed[name][np.isfinite(changed[name])][0]
            changed[name] = changed[name] + turn * np.round((start - own) / turn)
    return changed


def without_jumps(values: Array, unit: str) -> Array | None:
    """Return an angle without its jumps by a full turn; None where it does not wrap.

    It wraps if all values lie within one turn, and beyond each jump by more than half a turn it
    moves on as it does elsewhere. Steps above a quarter of a turn leave open which way it went.

    Parameters
    ----------
    values : ndarray, shape (n,)
        [rad, or the unit of a twin that states none]; NaN where it was not sampled.
    unit : str
        `rad`, or empty where degrees are possible too.
    """
    known = np.isfinite(values)
    own = values[known]
    turn = _turn(values, unit)
    if own.size < 3 or not np.ptp(own) <= turn * (1.0 + _SLACK):
        return None
    jumps = np.abs(np.diff(own)) > 0.5 * turn
    if not jumps.any() or jumps.all():
        return None
    whole = np.unwrap(own, period=turn)
    steps = np.abs(np.diff(whole))
    if steps[jumps].max() > _GOES_ON * steps[~jumps].max() or steps.max() > 0.25 * turn:
        return None
    found = values.copy()
    found[known] = whole
    return found


def _without_any_jump(values: Array, unit: str) -> Array:
    """Return an angle that is stated to wrap without its jumps, however fast it moves."""
    found, known = values.copy(), np.isfinite(values)
    if known.any():
        found[known] = np.unwrap(values[known], period=_turn(values, unit))
    return found


def _turn(values: Array, unit: str) -> float:
    """Size of a full turn: 360 where a unit is not stated and no turn in rad holds the values."""
    radians = 2.0 * math.pi
    if unit == "rad" or np.nanmax(values) - np.nanmin(values) <= radians * (1.0 + _SLACK):
        return radians
    return 360.0


def _units(twin: FmuTwin) -> dict[str, str]:
    entries = {**twin.file.inputs, **twin.file.outputs}
    variables = twin.binding.variables
    return {name: variables[e.variable].variable.si_unit for name, e in entries.items()}


def _wraps_itself(
    twin: FmuTwin,
    recording: Recording,
    names: Sequence[str] | dict[str, Array],
    units: dict[str, str],
) -> bool:
    run = twin.run({}, recording)
    return run.status == "ok" and any(
        without_jumps(run.signal(name), units[name]) is not None for name in names
    )


def _start(
    recording: Recording, changed: dict[str, Array], units: dict[str, str], names: tuple[str, str]
) -> float | None:
    """First value of a reference in the unit of an output; None where there is none."""
    asked, output = names
    reference = changed.get(asked, recording.signals.get(asked))
    if reference is None or units.get(asked) != units[output]:
        return None
    known = reference[np.isfinite(reference)]
    return float(known[0]) if known.size else None
