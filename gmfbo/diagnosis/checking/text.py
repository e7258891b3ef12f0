"""A check as a few lines of text: faults first, then the effects that could show."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from gmfbo.diagnosis.checking.grouped_findings import grouped, told_together
from gmfbo.diagnosis.locating.parity import FAILS_ABOVE
from gmfbo.plain_words import duration, number, percent, quantity, words, wrapped
from gmfbo.units import unit_words

if TYPE_CHECKING:
    from gmfbo.diagnosis.checking.result import (
        Check,
        Finding,
        RecordingFacts,
        ResponseSeen,
        Showable,
    )

# What drives lack most often, one of each kind; the others stand behind `every`.
_USUAL = (
    "coulomb_friction",
    "load_dependent_friction",
    "backlash",
    "torsional_compliance",
    "cogging_torque",
    "torque_ripple",
    "constant_torque_offset",
    "actuator_saturation",
    "actuator_lag",
    "transport_delay",
    "sensor_eccentricity",
)
_LOGGED = {
    "held": "the value still in force when the row was measured",
    "new": "the value just computed from the row's measurement",
}
_MOST_ALONE = 6  # recordings that have a column of their own
_MOST_FINDINGS = 8
_NOTHING = 1e-6  # of the largest: an end of a range that is printed as 0
_FAR = 20.0  # times the size shown by all recordings together: as good as never


def check_lines(check: Check, *, every: bool = False) -> list[str]:
    """Return lines of at most 79 characters.

    Parameters
    ----------
    check : Check
        The result of the check.
    every : bool
        Tell each finding by itself, and all effects instead of the usual ones.
    """
    return [
        *_findings(check, every),
        "",
        *_recordings(check),
        "",
        *_columns(check),
        *_controller(check),
        "",
        *_responses(check),
        *_sizes(check, every),
        *_silent(check),
        f"cost: {check.cost.simulations} simulations in {check.cost.seconds:.1f} s",
    ]


def _findings(check: Check, every: bool) -> list[str]:
    files = len(check.recordings)
    runs = f"{files} recording{'s' if files != 1 else ''}"
    alike = [[one] for one in check.findings] if every else grouped(check.findings)
    if not alike:
        which = "it" if files == 1 else "them"
        return [f"{check.twin}: {runs}, nothing wrong with {which} was seen", *_notes(check)]
    count = f"{len(alike)} thing{'s' if len(alike) != 1 else ''}"
    lines = [f"{check.twin}: {runs}, {count} to look at", *_notes(check)]
    shown = alike if every else alike[:_MOST_FINDINGS]
    for group in shown:
        what = told_together([finding.what for finding in group])
        lines += wrapped(f"{_title(group)}: {what}", "! ")
        lines += wrapped(told_together([finding.cure for finding in group]), "  -> ")
    if len(alike) > len(shown):
        lines.append(f"  and {len(alike) - len(shown)} more: --all")
    return lines


def _notes(check: Check) -> list[str]:
    """What was changed in the recordings or taken for granted: all below rests on it."""
    return [line for note in check.notes for line in wrapped(note, "note: ")]


def _title(group: Sequence[Finding]) -> str:
    """Place of a finding: "run0.csv and 2 more, torque command"."""
    first = group[0]
    others = len({finding.recording for finding in group}) - 1
    place = f"{first.recording} and {others} more" if others else first.recording
    parts = [part for part in (place, words(first.signal)) if part]
    return ", ".join(parts) or "all recordings"


def _table(told: Sequence[tuple[str, ...]]) -> list[str]:
    """Align the first column left, the others right; a long first column is cut."""
    rows = [(_cut(first, 30), *rest) for first, *rest in told]
    wide = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return ["  ".join([row[0].ljust(wide[0]), *map(str.rjust, row[1:], wide[1:])]) for row in rows]


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most - 3]}..."


def _recordings(check: Check) -> list[str]:
    place, speed = (unit_words(check.units[key]) for key in ("position", "velocity"))
    rows = [
        (
            "recording",
            "time",
            "up to",
            "reversals",
            f"position [{place}]",
            f"speed [{speed}]",
            "rows",
        )
    ]
    for name, facts in check.recordings.items():
        rows.append(
            (
                _cut(name, 16),
                f"{number(facts.duration)} s",
                f"{_hertz(facts.bandwidth)} Hz" if math.isfinite(facts.bandwidth) else "-",
                str(facts.reversals),
                _range(facts.position) if facts.has_position else "-",
                _range(facts.speed),
                _rows(facts),
            )
        )
    if all(math.isfinite(facts.bandwidth) for facts in check.recordings.values()):
        return _table(rows)
    return [*_table(rows), *wrapped(_no_response(check), "up to -: ")]


def _no_response(check: Check) -> str:
    """Why a recording tells no highest frequency."""
    if not check.responses:
        return "no recorded input moves"
    source = words(check.responses[0].source)
    return f"noise hides the response to {source} at all frequencies, or the recording is too short"


def _hertz(frequency: float) -> str:
    return f"{frequency:.0f}" if frequency >= 10.0 else number(frequency, 2)


def _range(ends: tuple[float, float]) -> str:
    least = _NOTHING * max(map(abs, ends))
    return " to ".join("0" if abs(end) < least else number(end, 2) for end in ends)


def _rows(facts: RecordingFacts) -> str:
    step = duration(facts.clock.step)
    return step if facts.clock.jitter < 1e-3 else f"{step} +-{percent(facts.clock.jitter)}"


def _columns(check: Check) -> list[str]:
    """Table of the compared columns: coarsest resolution and largest misalignment of all files.

    How late a column is stands there only where the controller tells it.
    """
    rows = [("column", "resolution", "noise", "peak", "late ms", "scale")]
    names = dict.fromkeys(n for f in check.recordings.values() for n in f.alignment)
    for name in names:
        facts = [f for f in check.recordings.values() if name in f.alignment and name in f.columns]
        if not facts:
            continue
        own = [f.columns[name] for f in facts]
        seen = [f.alignment[name] for f in facts]
        # Against the twin, friction that it lacks makes a column late whose clock is right.
        shifts = [a.shift for a in seen if a.basis == "controller" and math.isfinite(a.shift)]
        late = max(shifts, key=abs, default=math.nan)
        scales = [a.scale for a in seen if math.isfinite(a.scale)]
        scale = max(scales, key=lambda s: abs(s - 1.0), default=math.nan)
        quantum = max(c.resolution for c in own)
        rows.append(
            (
                words(name),
                quantity(quantum, own[0].unit, 2) if quantum else "continuous",
                quantity(max(c.noise for c in own), own[0].unit, 2),
                _peak(max((max(abs(c.low), abs(c.high)), c.limit, c.unit) for c in own)),
                f"{round(1e3 * late, 2) + 0.0:.2f}" if math.isfinite(late) else "-",
                f"{scale:.3f}" if math.isfinite(scale) else "-",
            )
        )
    told = [
        line
        for name, logged in check.logged.items()
        for line in wrapped(f"each row holds {_LOGGED[logged]}", f"{words(name)}: ")
    ]
    return [*_table(rows), *told]


def _peak(told: tuple[float, float | None, str]) -> str:
    peak, limit, unit = told
    if limit is None:
        return quantity(peak, unit, 2)
    return f"{number(peak, 2)} of {quantity(limit, unit, 2)}"


def _controller(check: Check) -> list[str]:
    if check.parity_why_not:
        return wrapped(f"not checked: {check.parity_why_not}", "controller: ")
    worst = max(facts.parity for facts in check.recordings.values())
    word = "computes" if worst <= FAILS_ABOVE else "does not compute"
    but = ""
    if worst > FAILS_ABOVE and not check.findings:
        word, but = "computes", ", but for a column's scale, time or offset within its tolerance"
    shown = f"{worst:.0f}" if worst >= 10.0 else f"{worst:.2f}"
    excess = f"mean square {shown}, fails above {FAILS_ABOVE:g}"
    return wrapped(f"{word} what was recorded{but} ({excess})", "controller: ")


def _responses(check: Check) -> list[str]:
    if not check.responses:
        return []
    lines = []
    for one in check.responses:
        told = f"{words(one.source)} to {words(one.signal)}: {_response(one)}"
        lines += wrapped(told, "")
    return [*lines, ""]


def _response(one: ResponseSeen) -> str:
    low, high = one.trusted
    if not math.isfinite(high):
        return "the response cannot be trusted at any frequency"
    band = f"trusted from {_hertz(low)} to {_hertz(high)} Hz, twin "
    if not one.apart:
        return f"{band}agrees within noise"
    return f"{band}{percent(one.apart)} apart at {_hertz(one.apart_at)} Hz"


def _sizes(check: Check, every: bool) -> list[str]:
    chosen = [n for n in check.showable if every or n in _USUAL]
    if not chosen:
        return []
    names = list(check.recordings)
    own = names if len(names) <= _MOST_ALONE else []
    rows = [("smallest size that would show", "together", *(_cut(n, 10) for n in own))]
    for name in chosen:
        size = check.showable[name]
        rows.append(
            (
                words(name),
                quantity(size.together, size.unit, 2),
                *(_times(size, n) for n in own),
            )
        )
    lines = _table(rows)
    more = len(check.showable) - len(chosen)
    return [*lines, f"and {more} more effects: --all"] if more else lines


def _times(size: Showable, recording: str) -> str:
    """Ratio of the size that one recording alone shows to that of all together, as text."""
    ratio = size.alone.get(recording, math.inf) / size.together
    return f"x{ratio:.1f}" if ratio < _FAR else "-"


def _silent(check: Check) -> list[str]:
    entries = check.not_testable
    if not entries:
        return []
    reasons: dict[str, list[str]] = {}
    for entry in entries:
        reasons.setdefault(entry.why, []).append(words(entry.name))
    told = "; ".join(f"{', '.join(names)} ({why})" for why, names in reasons.items())
    return wrapped(told, "cannot show: ")
