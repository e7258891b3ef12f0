"""Query cost of a run, in units of a real run."""

from __future__ import annotations

IS1_COST = 1.0
"""Cost of a real run: the unit."""

TWIN_COST = 0.1
"""Cost of a twin run, corrected or not, by the paper; not the acquisition's H."""
