"""What a tuning method is: the names that a method of one's own needs."""

from __future__ import annotations

from gmfbo.tuning.query.method import CorrectionOptions, Method, Proposal, Recommendation

__all__ = ["CorrectionOptions", "Method", "Proposal", "Recommendation"]
