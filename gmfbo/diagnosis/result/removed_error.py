"""How much of the explainable error the named physics removes, in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from gmfbo.plain_words import percent

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.findings import Findings

STILL_FOLLOWS = "what is left still follows the reference"

_MOST_BELOW_ALL = 999  # thousandths: the most that one decimal shows below 100 %


def still_follows(diagnosis: Findings) -> bool:
    """Whether a held-out residual follows the reference more than chance makes it."""
    return any(test.follows > test.bound for test in diagnosis.residual_tests)


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
