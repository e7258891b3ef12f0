"""Columns that are off by more than usual, told beside the law that would explain the same."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gmfbo.plain_words import percent, quantity, words
from gmfbo.units import quantity as prefixed

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.estimated import Alignment
    from gmfbo.diagnosis.result.findings import Findings


def misaligned_sentence(diagnosis: Findings) -> str:
    """Say that columns were logged wrongly, or a law is missing; empty where none is far off.

    A column without a law that would explain the same is told where no physics is: beside physics
    that is missing it takes the sign of that.
    """
    rivals = dict.fromkeys(one.rival for one in diagnosis.alignment.values() if one.rival)
    told = [_either_or(diagnosis, rival) for rival in rivals]
    if diagnosis.verdict in ("none", "parameters"):
        told += _alone(diagnosis)
    return " ".join(told)


def _alone(diagnosis: Findings) -> list[str]:
    off = [
        f"{words(name)} was logged {_off(one, _unit(diagnosis, name))}"
        for name, one in diagnosis.alignment.items()
        if one.beyond_prior and not one.rival
    ]
    if not off:
        return []
    told = f"{' and '.join(off)}, which is more than usual"
    what = "that column" if len(off) == 1 else "those columns"
    return [f"{told[0].upper()}{told[1:]}: correct {what}, and diagnose again."]


def _either_or(diagnosis: Findings, rival: str) -> str:
    columns = " and ".join(
        f"{words(name)} was logged {_off(one, _unit(diagnosis, name))}"
        for name, one in diagnosis.alignment.items()
        if one.rival == rival
    )
    return (
        f"Either {columns}, which is more than usual, or {words(rival)} is missing from the twin: "
        "that explains the recordings as well."
    )


def _unit(diagnosis: Findings, signal: str) -> str:
    return next((curve.unit for curve in diagnosis.curves if curve.signal == signal), "")


def _off(one: Alignment, unit: str) -> str:
    """What is off by most, in words."""
    kind = max(one.beyond_prior, key=lambda kind: one.beyond_prior[kind], default="shift")
    if kind == "scale":
        side = "large" if one.scale > 1.0 else "small"
        return f"{percent(abs(one.scale - 1.0))} too {side}"
    if kind == "offset":
        side = "high" if one.offset > 0.0 else "low"
        return f"{quantity(abs(one.offset), unit)} too {side}"
    return f"{prefixed(abs(one.shift), 's')} {'late' if one.shift > 0.0 else 'early'}"
