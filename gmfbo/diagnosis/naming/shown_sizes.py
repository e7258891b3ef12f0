"""Effects that recordings would show, from which size, and those that they would not."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from gmfbo.diagnosis.comparison.moves import Element, Response, Shown
from gmfbo.diagnosis.comparison.numbers import TOLD_APART, UNLIKE
from gmfbo.diagnosis.result.named_effect import DetectableSize
from gmfbo.physics import CATALOGUE, Excitation, Units
from gmfbo.plain_words import NOT_EXCITED

_NOTHING = "changes nothing in these recordings"
_TOO_FAINT = f"{NOT_EXCITED}: no size that is looked for would show"
_RUNS_AWAY = "the twin does not run to its end with it"


def detectable_sizes(
    seen: Sequence[Shown], excitation: Excitation, named: Collection[str], units: Units
) -> dict[str, DetectableSize]:
    """Smallest size of each effect not named that would have been told apart.

    Parameters
    ----------
    seen : sequence of Shown
        How well each effect at its start is seen.
    excitation : Excitation
        By the recordings.
    named : collection of str
        Effects that are left out.
    units : Units
        Of the twin.
    """
    sizes: dict[str, DetectableSize] = {}
    for entry in seen:
        candidate = entry.element.candidate
        if candidate is None or candidate.effect in named or candidate.searched > 1:
            continue  # several lines together show at a smaller size than any of them
        law, smallest = candidate.law, _least_size(entry, excitation)
        if smallest is not None and not (law.name in sizes and sizes[law.name].size <= smallest):
            sizes[law.name] = DetectableSize(law.size_name, smallest, units.resolve(law.size_unit))
    return {name: sizes[name] for name in CATALOGUE if name in sizes}


def _least_size(entry: Shown, excitation: Excitation) -> float | None:
    """Smallest size of an effect that is told apart; None if it is looked for at none such."""
    candidate, information = entry.element.candidate, entry.information
    assert candidate is not None
    law, bounds, share = candidate.law, candidate.law.bounds(excitation), 1.0
    sizes = [name for name, (low, _) in bounds.items() if low <= 0.0 and name in candidate.values]
    if sizes and information > 0.0:
        share = float(np.sqrt(TOLD_APART / information))
        if any(share * candidate.values[name] > bounds[name][1] for name in sizes):
            return None
    elif information < TOLD_APART:
        return None  # a limit, which shows whole or not at all
    smallest = share * law.size({**candidate.more, **candidate.values}, excitation)
    return max(smallest, law.floor(excitation))


def not_shown(
    elements: Sequence[Element],
    found: Sequence[Response],
    seen: Sequence[Shown],
    said: Collection[str],
    excitation: Excitation,
) -> dict[str, str]:
    """Effects about which recordings tell nothing, and why.

    Parameters
    ----------
    elements : sequence of Element
        All that compete.
    found : sequence of Response
        Of those that the twin gets through.
    seen : sequence of Shown
        How well recordings show these.
    said : collection of str
        Effects that are told, and left out.
    excitation : Excitation
        By the recordings.
    """
    simulated = {response.element.name for response in found}
    competing = [e.name for e in elements if e.candidate is not None]
    running_away = {name: _RUNS_AWAY for name in competing if name not in simulated}
    effects = [e for e in seen if e.element.candidate is not None]
    telling = {e.element.name for e in effects if _least_size(e, excitation) is not None}
    names = {e.element.name for e in effects} - telling - set(said)
    too_faint = dict.fromkeys(names, _TOO_FAINT)
    return {**too_faint, **_like_parameters(seen, said), **running_away}


def _like_parameters(seen: Sequence[Shown], said: Collection[str]) -> dict[str, str]:
    """Effects that the refitted parameters can make by themselves, and which of them does."""
    best: dict[str, Shown] = {}
    for entry in seen:
        name = entry.element.name
        if entry.element.candidate is None or name in said:
            continue
        if name not in best or entry.unlike > best[name].unlike:
            best[name] = entry
    return {
        name: f"is parameter {entry.nearest}" if entry.unlike > 0.0 and entry.nearest else _NOTHING
        for name, entry in best.items()
        if entry.unlike < UNLIKE
    }
