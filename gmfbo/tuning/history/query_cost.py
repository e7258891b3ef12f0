"""Query cost of a run, in units of a real run."""

from __future__ import annotations

IS1_COST = 1.0
"""Cost of a real run: the unit."""

TWIN_COST = 0.1
"""Cost of a run of the twin, corrected or not, as the paper counts it; not the acquisition's H."""
