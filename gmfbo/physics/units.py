"""Words for a value with its unit, for the statement of an effect of one's own."""

from __future__ import annotations

from gmfbo.units import quantity

__all__ = ["quantity"]
