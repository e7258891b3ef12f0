"""Effects that recordings would show, from which size, and those that they would not."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from gmfbo.diagnosis.comparison.moves import Element, Response, Shown
from gmfbo.diagnosis.comparison.numbers import TOLD_APART, UNLIKE
from gmfbo.diagnosis.result.named_effect import DetectableSize
from gmfbo.physics import CATALOGUE, Excitation, Units

_NOTHING = "changes nothing in these recordings"
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
        if candidate is None or candidate.effect in named or entry.information <= 0.0:
            continue
        if candidate.searched > 1:
            continue  # several lines together show at a smaller size than any of them
        law = candidate.law
        smallest = law.size({**candidate.more, **candidate.values}, excitation)
        if any(low <= 0.0 for low, _ in law.bounds(excitation).values()):
            smallest *= float(np.sqrt(TOLD_APART / entry.information))
        elif entry.information < TOLD_APART:
            continue  # a limit, which shows whole or not at all
        smallest = max(smallest, law.floor(excitation))
        if law.name not in sizes or smallest < sizes[law.name].size:
            sizes[law.name] = DetectableSize(law.size_name, smallest, units.resolve(law.size_unit))
    return {name: sizes[name] for name in CATALOGUE if name in sizes}


def not_shown(
    elements: Sequence[Element],
    found: Sequence[Response],
    seen: Sequence[Shown],
    said: Collection[str],
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
    """
    simulated = {response.element.name for response in found}
    competing = [e.name for e in elements if e.candidate is not None]
    running_away = {name: _RUNS_AWAY for name in competing if name not in simulated}
    return {**_like_parameters(seen, said), **running_away}


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
