"""What a reader has to know before using the values of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from gmfbo.diagnosis.result.certainty import is_sure
from gmfbo.plain_words import interval, listed, quantity

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.estimated import EstimatedParameter
    from gmfbo.diagnosis.result.findings import Findings

NOT_CONVERGED = "The fit of these values was stopped before it had converged."


def cautions(diagnosis: Findings) -> tuple[str, ...]:
    """Sentences that belong beside the values of a diagnosis; none where all is well."""
    in_verdict = (not_compared(diagnosis), too_narrow_ranges(diagnosis), range_ends(diagnosis))
    return (*filter(None, in_verdict), *beside_the_verdict(diagnosis))


def beside_the_verdict(diagnosis: Findings) -> tuple[str, ...]:
    """Those of them that the verdict's own sentence leaves out."""
    moving = f"{NOT_CONVERGED} They, and their intervals, may still move."
    stopped = "" if diagnosis.converged else moving
    return tuple(filter(None, (drifts_words(diagnosis), stopped)))


def drifts_words(diagnosis: Findings) -> str:
    """Sentences about parameters that differ from recording to recording; empty without any."""
    return " ".join(
        f"{name} {_drift(one.drifts, one.unit)}."
        for name, one in diagnosis.parameters.items()
        if one.drifts
    )


def _drift(drifts: Mapping[str, float], unit: str) -> str:
    """Verb with the ends of a drift [unit]; a direction only where no recording goes back."""
    told = [f"{quantity(value, unit)} in {recording}" for recording, value in drifts.items()]
    values = list(drifts.values())
    low, high = values.index(min(values)), values.index(max(values))
    if values[0] != values[-1]:
        if values == sorted(values):
            return f"rises from {told[0]} to {told[-1]}"
        if values == sorted(values, reverse=True):
            return f"falls from {told[0]} to {told[-1]}"
    return f"varies between {told[low]} and {told[high]}"


def are_sure(diagnosis: Findings) -> bool:
    """Whether all fixed parameters that are told to be wrong are so for sure."""
    told = (one.probability for one in diagnosis.parameters.values() if one.is_moved)
    return all(one is None or is_sure(one) for one in told)


def withheld_twin(diagnosis: Findings) -> str:
    """A sentence on a twin that is not handed back; empty where one is."""
    if not diagnosis.fit.twin_is_withheld:
        return ""
    return (
        "No corrected twin is handed back: the twin as it came meets the unseen recordings better."
    )


def not_compared(diagnosis: Findings) -> str:
    """A sentence about outputs that a recording does not hold; empty where all were compared."""
    first, *others = diagnosis.not_compared or ("",)
    more = f" and {len(others)} more" if others else ""
    return f"Not compared: {first}{more}." if first else ""


def combinations_text(diagnosis: Findings) -> str:
    """Combinations of parameters with their intervals; empty where each is seen by itself."""
    return "; ".join(
        f"{one.expression} = {interval(one.value, one.low, one.high, '')}"
        for one in diagnosis.combinations
    )


def too_narrow_ranges(diagnosis: Findings) -> str:
    """Sentences about ranges that the recordings contradict; empty where there are none."""
    beyond = {
        name: one
        for name, one in diagnosis.parameters.items()
        if one.at_bound is not None and one.is_beyond
    }
    if not beyond:
        return ""
    asked = listed(
        f"{quantity(one.value, one.unit)} where {name} may be at {_bound(one)} ({one.stated})"
        for name, one in beyond.items()
    )
    return f"{_at_ends(beyond)}. The recordings ask for {asked}: widen {_them(beyond)} there."


def range_ends(diagnosis: Findings) -> str:
    """A sentence about values that a range holds at its end; empty where there are none."""
    held = {
        name: one
        for name, one in diagnosis.parameters.items()
        if one.at_bound is not None and not one.is_beyond
    }
    if not held:
        return ""
    where = listed(f"{name} may be at {_bound(one)} ({one.stated})" for name, one in held.items())
    return (
        f"{_at_ends(held)}: {where}. If {'that is' if len(held) == 1 else 'these are'} no physical "
        f"limit, widen {_them(held)} and diagnose again."
    )


def _at_ends(parameters: Mapping[str, EstimatedParameter]) -> str:
    if len(parameters) == 1:
        return f"{next(iter(parameters))} is at the end of its range"
    return f"{listed(parameters)} are at the ends of their ranges"


def _bound(one: EstimatedParameter) -> str:
    return f"{'most' if one.at_bound == 'high' else 'least'} {quantity(one.bound, one.unit)}"


def _them(parameters: Mapping[str, EstimatedParameter]) -> str:
    return "it" if len(parameters) == 1 else "them"
