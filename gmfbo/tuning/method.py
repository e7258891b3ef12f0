"""Public names for a tuning method of one's own."""

from __future__ import annotations

from gmfbo.tuning.query.method import CorrectionOptions, Method, Proposal, Recommendation

__all__ = ["CorrectionOptions", "Method", "Proposal", "Recommendation"]
