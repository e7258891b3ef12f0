"""Why runs of an earlier study were not taken over, in words."""

from __future__ import annotations

from collections.abc import Mapping


def reasons_told(reasons: Mapping[str, int]) -> tuple[str, ...]:
    """Reasons why runs were not taken over, each with its number in front.

    Parameters
    ----------
    reasons : mapping of str to int
        Number of runs by reason.
    """
    return tuple(f"{count}: {why}" for why, count in reasons.items() if count)
