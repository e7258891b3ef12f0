"""Findings that say the same of several recordings, as one with the range of its numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gmfbo.diagnosis.checking.result import Finding

_ONE = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
# A digit within a name or a file is no number; several times in a row are one place of a sentence.
_NUMBERS = re.compile(rf"(?<![\w.])({_ONE}(?:, {_ONE})*)( \.\.\.)?(?!\w|\.\w)")


def grouped(findings: Sequence[Finding]) -> list[list[Finding]]:
    """Findings that differ in their recording and numbers alone, as groups.

    Parameters
    ----------
    findings : sequence of Finding
        Worst first, as the groups are.
    """
    groups: dict[tuple[str, str, str, str], list[Finding]] = {}
    for finding in findings:
        said = (_NUMBERS.sub("#", finding.what), _NUMBERS.sub("#", finding.cure))
        groups.setdefault((finding.kind, finding.signal, *said), []).append(finding)
    return list(groups.values())


def told_together(sentences: Sequence[str]) -> str:
    """Return the one sentence, where a number differs with the smallest and the largest.

    Parameters
    ----------
    sentences : sequence of str
        That differ in their numbers alone.
    """
    found = zip(*(_NUMBERS.findall(sentence) for sentence in sentences), strict=True)
    ranges = [_range(entries) for entries in found]
    return _NUMBERS.sub(lambda place: ranges.pop(0), sentences[0])


def _range(entries: Sequence[tuple[str, str]]) -> str:
    """ "1.2" where all are; "0.8 to 1.2 ..." where the numbers differ and some were left out."""
    if len(set(entries)) == 1:
        return "".join(entries[0])
    numbers = sorted((n for listed, _ in entries for n in listed.split(", ")), key=float)
    more = max(left_out for _, left_out in entries)
    if float(numbers[0]) == float(numbers[-1]):
        return f"{numbers[0]}{more}"
    return f"{numbers[0]} to {numbers[-1]}{more}"
