"""What a diagnosis came to, in one screen of 80 by 24."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.diagnosis.plain_words import number, percent, probability, words
from gmfbo.diagnosis.summary import fit_lines, parameter_texts, rivals_text

if TYPE_CHECKING:
    from gmfbo.diagnosis import Diagnosis
    from gmfbo.diagnosis.named_effect import NamedEffect

WIDTH = 79
HEIGHT = 23  # the prompt takes the last line
INDENT = 14


def screenful(diagnosis: Diagnosis, written: Sequence[Path] = ()) -> list[str]:
    """Return the lines of one screen; the report has what does not fit.

    Parameters
    ----------
    diagnosis : Diagnosis
        What was found.
    written : sequence of Path
        Files that were written.

    Returns
    -------
    list of str
        At most 23 lines of at most 79 characters.
    """
    lines: list[str] = []
    for most in (5, 3, 2, 1):
        lines = _lines(diagnosis, written, most)
        if len(lines) <= HEIGHT:
            break
    return lines[:HEIGHT]


def _lines(diagnosis: Diagnosis, written: Sequence[Path], most: int) -> list[str]:
    """All lines, with at most so many effects, signals and notes."""
    sentence = textwrap.wrap(diagnosis.sentence, WIDTH)
    lines = [*_cut(sentence, 2 + most), ""]
    for effect in diagnosis.effects[:most]:
        lines += _effect(effect, 1 + (most > 1))
    lines += _more(len(diagnosis.effects) - most, "effects")
    table = fit_lines(diagnosis)
    lines += table[: most + 1]
    lines += _more(len(table) - 1 - most, "signals")
    lines += _removed(diagnosis)
    lines += _entry("where", _where(diagnosis), min(most, 2))
    lines += _entry("not testable", _not_testable(diagnosis), min(most, 2))
    lines += _entry("next", _next(diagnosis), min(most, 2))
    for note in diagnosis.notes[:most]:
        lines += _entry("note", note, min(most, 2))
    lines += _entry("cost", _cost(diagnosis), 1)
    return lines + _entry("written", _files(written), min(most, 2))


def _cut(lines: list[str], most: int) -> list[str]:
    """At most so many lines; dots where some are left out."""
    if len(lines) <= most:
        return lines
    return [
        *lines[: most - 1],
        textwrap.shorten(lines[most - 1], WIDTH - 4, placeholder="") + " ...",
    ]


def _entry(name: str, text: str, most: int) -> list[str]:
    if not text:
        return []
    wrapped = textwrap.wrap(text, WIDTH - INDENT)
    if len(wrapped) > most:
        wrapped = wrapped[:most]
        wrapped[-1] = textwrap.shorten(wrapped[-1], WIDTH - INDENT - 4, placeholder="") + " ..."
    heads = [name, *[""] * (len(wrapped) - 1)]
    return [f"{head:<{INDENT}}{line}" for head, line in zip(heads, wrapped, strict=True)]


def _more(count: int, what: str) -> list[str]:
    return [f"{'':<{INDENT}}and {count} more {what}, see the report"] if count > 0 else []


def _effect(effect: NamedEffect, most: int) -> list[str]:
    told = f"{words(effect.name)}, probability {probability(effect.probability)}: "
    lines = _entry("missing", told + ", ".join(parameter_texts(effect)), most)
    rivals = rivals_text(effect)
    return lines + (_entry("", f"cannot be told from {rivals}", most) if rivals else [])


def _removed(diagnosis: Diagnosis) -> list[str]:
    share = diagnosis.fit.explainable_error_removed
    if share is None:
        return []
    return _entry("removed", f"{percent(share)} of the error that physics can explain", 1)


def _where(diagnosis: Diagnosis) -> str:
    location = diagnosis.location
    parts = [part for part in (location.signal_path, location.region) if part]
    if location.times:
        window, *others = location.times
        more = f" and {len(others)} more" if others else ""
        parts.append(f"{window.recording} {number(window.start)} to {number(window.end)} s{more}")
    return ", ".join(parts)


def _not_testable(diagnosis: Diagnosis) -> str:
    entries = diagnosis.not_testable
    if not entries:
        return ""
    first = "; ".join(f"{words(entry.name)} ({entry.why})" for entry in entries[:3])
    return f"{len(entries)}: {first}{'; ...' if len(entries) > 3 else ''}"


def _next(diagnosis: Diagnosis) -> str:
    planned = diagnosis.next_experiment
    if planned is None:
        return ""
    apart = " from ".join(words(name) for name in planned.separates)
    told = f"play {planned.reference}"
    return f"{told} to tell {apart}: {planned.why}" if apart else f"{told}: {planned.why}"


def _cost(diagnosis: Diagnosis) -> str:
    cost = diagnosis.cost
    return f"{cost.simulations} simulations in {cost.seconds:.1f} s, seed {diagnosis.seed}"


def _files(written: Sequence[Path]) -> str:
    if not written:
        return ""
    return f"{written[0].parent}: {', '.join(path.name for path in written)}"
