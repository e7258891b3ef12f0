"""Common parts of effects with a load of their own."""

from __future__ import annotations

from gmfbo.physics.effect import EffectParameter
from gmfbo.physics.excitation import Excitation


def load_inertia() -> EffectParameter:
    """Make the share of the twin's inertia that sits behind the transmission."""
    return EffectParameter(
        "load_inertia",
        "Load inertia",
        "inertia",
        low=lambda e: 0.02 * e.shaft_inertia,
        high=lambda e: 0.9 * e.shaft_inertia,
        scale=lambda e: 0.2 * e.shaft_inertia,
    )


def unknown_inertia(excitation: Excitation) -> str | None:
    """Reason if the twin's inertia, of which the load is a part, is unknown."""
    if excitation.inertia is None:
        return "the inertia of the twin's shaft is not known: name its parameter in [roles]"
    return None
