"""What a reader has to know before using the values of a diagnosis."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.findings import Findings

NOT_CONVERGED = (
    "The fit of these values was stopped before it had converged: they, and their intervals, may "
    "still move."
)


def cautions(diagnosis: Findings) -> tuple[str, ...]:
    """Sentences that belong beside the values of a diagnosis; none where all is well."""
    return () if diagnosis.converged else (NOT_CONVERGED,)
