"""How much of the explainable error the named physics removes, and what is left, in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from gmfbo.plain_words import listed, percent, words

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.explained import Remainder
    from gmfbo.diagnosis.result.findings import Findings
    from gmfbo.diagnosis.result.named_effect import NamedEffect

STILL_FOLLOWS = "what is left still follows the reference"

LEAST_TOLD = 0.01
"""Of what is more than noise: a smaller remainder does not belong in a sentence."""

_HALF = 0.5

_MOST_BELOW_ALL = 999  # thousandths: the most that one decimal shows below 100 %


def still_follows(diagnosis: Findings) -> bool:
    """Whether a held-out residual follows the reference more than chance makes it."""
    return any(test.follows > test.bound for test in diagnosis.residual_tests)


def follows_clearly(diagnosis: Findings) -> bool:
    """The same by more than the small errors that every rig has."""
    return any(test.follows > max(test.bound, test.tolerance) for test in diagnosis.residual_tests)


def removed_percent(diagnosis: Findings) -> str:
    """Share of the explainable error that is removed, as per cent; empty where none is known.

    "100 %" says that nothing is left but noise. So it stands only where every residual that was
    tested passes; otherwise a share that rounds to it is rounded down to one decimal.
    """
    share = diagnosis.fit.explainable_error_removed
    if share is None or not math.isfinite(share):
        return ""
    tests = diagnosis.residual_tests
    all_pass = bool(tests) and all(test.follows <= test.bound for test in tests)
    return percent(share) if all_pass else rounded_down(share)


def rounded_down(share: float) -> str:
    """Share as per cent; one that would round to 100 % is rounded down to one decimal."""
    shown = percent(share)
    if shown != percent(1.0):
        return shown
    return f"{min(math.floor(1000.0 * share), _MOST_BELOW_ALL) / 10.0:.1f} %"


def removed_words(diagnosis: Findings) -> str:
    """Share removed with what it is a share of, and whether what is left follows the reference."""
    share = removed_percent(diagnosis)
    if not share:
        return ""
    left = f"; {STILL_FOLLOWS}" if still_follows(diagnosis) else ""
    return f"{share} of the error that physics can explain{left}"


def share_words(effect: NamedEffect) -> str:
    """What an effect explains of what is more than noise; empty where that is not known."""
    share = effect.share
    if share is None:
        return ""
    return f"explains {percent(share.value)} [{percent(share.low)}, {percent(share.high)}]"


def explains_most(remainder: Remainder | None) -> bool:
    """Whether the named laws explain more than half of what is more than noise."""
    return remainder is not None and remainder.share < _HALF


def resembling_words(remainder: Remainder | None) -> str:
    """Clause on the law that a function without a name looks like; "" where there is none."""
    likely = None if remainder is None else remainder.resembles
    if likely is None:
        return ""
    return f", most like {words(likely.effect)} ({percent(likely.share)} of it)"


def remainder_words(remainder: Remainder | None) -> str:
    """What no law explains, as a clause; empty where it is next to nothing.

    A small share is told where it is known on what it depends: where one recording leaves far
    more than the others, what no law explains in those is a small share of all.
    """
    if remainder is None or (remainder.share < LEAST_TOLD and remainder.against is None):
        return ""
    is_small = remainder.share < LEAST_TOLD
    share = f"less than {100.0 * LEAST_TOLD:g} %" if is_small else percent(remainder.share)
    told = f"{share} of what is more than noise is explained by no law"
    if remainder.stand_ins:
        instead = listed(map(words, remainder.stand_ins))
        told = f"{share} of what is more than noise is left with {instead} in its place"
    if remainder.against is not None:
        told += f"; it depends on the {words(remainder.against)}{resembling_words(remainder)}"
    if remainder.where != "throughout":
        told += f"; most of it is in {remainder.where}"
    return told
