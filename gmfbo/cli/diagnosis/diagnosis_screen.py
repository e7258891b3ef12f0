"""Result of a diagnosis on one screen of 80 by 24."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.diagnosis.result.cautions import NOT_CONVERGED, combinations_text, drifts_words
from gmfbo.diagnosis.result.certainty import claim_of_set
from gmfbo.diagnosis.result.misaligned_columns import misaligned_sentence
from gmfbo.diagnosis.result.removed_error import remainder_words, removed_words, share_words
from gmfbo.diagnosis.result.summary import fit_lines, parameter_texts
from gmfbo.plain_words import WIDTH, interval, listed, number, probability, words

if TYPE_CHECKING:
    from gmfbo.diagnosis import Diagnosis
    from gmfbo.diagnosis.result.named_effect import NamedEffect

HEIGHT = 23  # the prompt takes the last line
INDENT = 13


@dataclass(frozen=True)
class _Detail:
    """Level of detail: lines of the sentence, effects and signals, notes and lines of an entry.

    An entry has one line at least; one that says what is missing, or drifts, has one more than
    others.
    """

    sentence: int
    entries: int
    wraps: int


# Tried in turn until the result fits; the last one always does.
_DETAILS = (
    _Detail(6, 5, 2),
    _Detail(5, 3, 1),
    _Detail(4, 2, 1),
    _Detail(3, 2, 1),
    _Detail(3, 1, 1),
    _Detail(2, 1, 1),
    _Detail(2, 1, 0),
)


def screenful(diagnosis: Diagnosis, written: Sequence[Path] = ()) -> list[str]:
    """Lines of one screen; the report has the rest.

    Returns
    -------
    list of str
        At most 23 lines of at most 79 characters.
    """
    lines: list[str] = []
    for detail in _DETAILS:
        lines = _lines(diagnosis, written, detail)
        if len(lines) <= HEIGHT:
            break
    return lines


def _lines(diagnosis: Diagnosis, written: Sequence[Path], detail: _Detail) -> list[str]:
    wraps = detail.wraps
    lines = [*_cut(textwrap.wrap(diagnosis.sentence, WIDTH), detail.sentence), ""]
    for effect in diagnosis.effects[: detail.entries]:
        lines += _effect(effect, wraps, len(diagnosis.effects) == 1)
    lines += _entry("or", misaligned_sentence(diagnosis), wraps + 1)
    lines += fit_lines(diagnosis, detail.entries)
    lines += _entry("removed", removed_words(diagnosis), 2)
    lines += _entry("left", remainder_words(diagnosis.remainder), wraps)
    lines += _entry("parameters", _refitted(diagnosis), wraps)
    lines += _entry("known only", combinations_text(diagnosis), wraps)
    lines += _entry("caution", "" if diagnosis.converged else NOT_CONVERGED, 1)
    lines += _entry("drifts", drifts_words(diagnosis), wraps + 1)
    lines += _entry("where", _where(diagnosis), wraps)
    lines += _entry("not testable", _not_testable(diagnosis), wraps)
    lines += _entry("next", _next(diagnosis), wraps)
    for note in diagnosis.notes[:wraps]:
        lines += _entry("note", note, wraps)
    lines += _entry("more", _left_out(diagnosis, detail), 1)
    lines += _entry("cost", _cost(diagnosis), 1)
    return lines + _entry("written", _files(written), 2)


def _cut(lines: list[str], most: int, width: int = WIDTH) -> list[str]:
    if len(lines) <= most:
        return lines
    last = textwrap.shorten(lines[most - 1], width - 4, placeholder="")
    return [*lines[: most - 1], f"{last} ..."]


def _entry(name: str, text: str, most: int) -> list[str]:
    if not text:
        return []
    wide = WIDTH - INDENT
    # A path or a name stays whole, even beyond the margin.
    wrapped = textwrap.wrap(text, wide, break_long_words=False, break_on_hyphens=False)
    wrapped = _cut(wrapped, max(most, 1), wide)
    heads = [name, *[""] * (len(wrapped) - 1)]
    return [f"{head:<{INDENT}}{line}" for head, line in zip(heads, wrapped, strict=True)]


def _left_out(diagnosis: Diagnosis, detail: _Detail) -> str:
    """How many entries this detail has no room for; empty where all are shown."""
    counts = {
        "effect": len(diagnosis.effects) - detail.entries,
        "signal": len(diagnosis.fit.signals) - detail.entries,
        "note": len(diagnosis.notes) - detail.wraps,
    }
    told = [f"{n} {what}{'s' if n > 1 else ''}" for what, n in counts.items() if n > 0]
    return f"{listed(told)}, see the report" if told else ""


def _effect(effect: NamedEffect, most: int, alone: bool) -> list[str]:
    told = f"{claim_of_set(effect)}, probability {probability(effect.set_probability)}"
    explained = share_words(effect)
    if explained and not alone:  # of one alone, it is what is removed
        told += f"; {explained}"
    lines = most + 1 if effect.indistinguishable_from or not alone else 1
    return [
        *_entry("missing", told, lines),
        *_entry("", ", ".join(parameter_texts(effect)), most),
    ]


def _refitted(diagnosis: Diagnosis) -> str:
    """Identifiable parameters of the twin, before and after the refit."""
    return "; ".join(
        f"{name} {number(one.nominal)} -> {interval(one.value, one.low, one.high, one.unit)}"
        f"{one.where_fixed}"
        for name, one in diagnosis.parameters.items()
        if one.identifiable
    )


def _where(diagnosis: Diagnosis) -> str:
    location = diagnosis.location
    parts = [part for part in (location.signal_path, location.region) if part]
    if location.times:
        window = location.times[0]
        more = " ..." if len(location.times) > 1 else ""
        parts.append(f"{window.recording} {number(window.start)}-{number(window.end)} s{more}")
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
    if not planned.reference:
        return planned.why
    apart = " from ".join(words(name) for name in planned.separates)
    told = f" to tell {apart}" if planned.threshold > 0.0 else ""
    return f"play {planned.reference}{told}: {planned.why}"


def _cost(diagnosis: Diagnosis) -> str:
    cost = diagnosis.cost
    return f"{cost.simulations} simulations in {cost.seconds:.1f} s, seed {diagnosis.seed}"


def _files(written: Sequence[Path]) -> str:
    if not written:
        return ""
    return f"{written[0].parent}: {', '.join(path.name for path in written)}"
