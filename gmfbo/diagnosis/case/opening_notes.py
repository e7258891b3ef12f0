"""Notes on what a case leaves out: else the twin would be judged without it in silence."""

from __future__ import annotations

from gmfbo.diagnosis.case.case import Case
from gmfbo.plain_words import listed


def not_scored(case: Case) -> list[str]:
    """A note where recordings have no window.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    """
    scored = {window.record for window in case.budget.windows}
    left = [r.name for k, r in enumerate(case.simulations.records) if k not in scored]
    if not left:
        return []
    return [
        f"{listed(left)}: not scored, since the recording starts in another state than the twin "
        'and ends before that is forgotten; state it in [initial] (a signal, a number or "fit"), '
        "or record longer"
    ]
