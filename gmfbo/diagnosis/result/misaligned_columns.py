"""Columns that are off by more than usual, told beside the law that would explain the same."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gmfbo.plain_words import percent, quantity, words
from gmfbo.units import quantity as prefixed

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.estimated import Alignment
    from gmfbo.diagnosis.result.findings import Findings


def misaligned_sentence(diagnosis: Findings) -> str:
    """Say that columns were logged wrongly, or a law is missing; empty where no law rivals them."""
    rivals = dict.fromkeys(one.rival for one in diagnosis.alignment.values() if one.rival)
    return " ".join(_either_or(diagnosis, rival) for rival in rivals)


def _either_or(diagnosis: Findings, rival: str) -> str:
    units = {curve.signal: curve.unit for curve in diagnosis.curves}
    columns = " and ".join(
        f"{words(name)} was logged {_off(one, units.get(name, ''))}"
        for name, one in diagnosis.alignment.items()
        if one.rival == rival
    )
    return (
        f"Either {columns}, which is more than usual, or {words(rival)} is missing from the twin: "
        "that explains the recordings as well."
    )


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
