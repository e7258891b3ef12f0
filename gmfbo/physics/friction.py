"""What the friction laws have in common."""

from __future__ import annotations

from gmfbo.physics.effect import EffectParameter, Values, positive
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Mask, States
from gmfbo.physics.units import Units

# Below half a percent of the command range, friction was never told from model error.
FLOOR_SHARE = 0.005


def floor(excitation: Excitation) -> float:
    """Smallest friction that is claimed, in the unit of the torque."""
    return FLOOR_SHARE * excitation.torque


def level(words: str = "Friction while sliding", name: str = "level") -> EffectParameter:
    """Make the parameter that holds a friction level."""
    return positive(name, words, "torque", lambda e: e.torque)


def bristle_deflection(excitation: Excitation) -> float:
    """Elastic displacement of a bristle that stands for plain sliding friction.

    Too small to be seen, and large enough that its stiffness k, held over a step h, satisfies
    k h^2 <= 0.1 J for a friction of a tenth of the torque range.

    Returns
    -------
    float
        In the unit of the position.
    """
    friction, share = 0.1 * excitation.torque, 0.1
    stable = friction * excitation.step**2 / (share * excitation.shaft_inertia)
    return max(0.2 * excitation.resolution, min(stable, 0.01 * excitation.stroke))


def fixed_deflection(excitation: Excitation) -> Values:
    """Give the bristle of a plain friction law its deflection."""
    return {"deflection": bristle_deflection(excitation)}


def acts_at_reversals(states: States, parameters: Values) -> Mask:
    """Friction shows most where the direction changes."""
    return states.near_reversals()


def reversal_region(parameters: Values, units: Units) -> str:
    """Say where plain friction shows."""
    return "where the velocity changes sign"


def no_reversal(excitation: Excitation) -> str | None:
    """Without a reversal, friction and a constant torque are one."""
    return None if excitation.reversals > 0 else "no reversal of the velocity"
