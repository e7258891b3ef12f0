"""Common parts of errors of the position sensor."""

from __future__ import annotations

from gmfbo.physics.excitation import Excitation


def floor(excitation: Excitation) -> float:
    """Smallest error of the reading that is claimed, in the unit of the position."""
    return max(0.5 * excitation.resolution, 2e-5 * excitation.stroke)
