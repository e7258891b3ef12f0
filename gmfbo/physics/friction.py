"""Common parts of the friction laws."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gmfbo.physics.effect import EffectParameter, Range, Units, Values, positive
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import Array, Mask, States

# Share of the torque range below which friction does not matter to a drive engineer.
FLOOR_SHARE = 1.5e-4

# Elastic displacement of a contact before it slides; a gear or a cable has more.
_CONTACT_ANGLE = 0.015  # [rad]
_CONTACT_SHARE = 0.004  # of a stroke in length

# Times the deflection that plain friction is given: less is too stiff for the step to show, more
# is presliding friction.
_LEAST_UNSEEN, _MOST_UNSEEN = 1.0 / 30.0, 3.0

Deflections = Callable[[Excitation], tuple[float, float]]


def floor(excitation: Excitation) -> float:
    """Smallest friction that is claimed, in the unit of the torque."""
    return FLOOR_SHARE * excitation.torque


def level(words: str = "Friction while sliding", name: str = "level") -> EffectParameter:
    """Make the parameter that holds a friction level."""
    return positive(name, words, "torque", lambda e: e.torque)


def _bristle_deflection(excitation: Excitation) -> float:
    """Elastic displacement of a bristle that stands for plain friction, in the position's unit.

    Too small to be seen, and large enough that its stiffness k, held over a step h, satisfies
    k h^2 <= 0.1 J for a friction of a tenth of the torque range.
    """
    friction, share = 0.1 * excitation.torque, 0.1
    stable = friction * excitation.step**2 / (share * excitation.shaft_inertia)
    return max(0.2 * excitation.resolution, min(stable, 0.01 * excitation.stroke))


def fixed_deflection(excitation: Excitation) -> Values:
    """Give the bristle of a plain friction law its deflection."""
    return {"deflection": _bristle_deflection(excitation)}


def own_deflection() -> EffectParameter:
    """Make the deflection of a plain friction law a nuisance: a contact has any, all too small."""
    return EffectParameter(
        "deflection",
        "Deflection of the bristle",
        "position",
        low=lambda e: _LEAST_UNSEEN * _bristle_deflection(e),
        high=lambda e: _MOST_UNSEEN * _bristle_deflection(e),
        scale=_bristle_deflection,
        hidden=True,
    )


def acts_at_reversals(states: States, parameters: Values) -> Mask:
    """Samples near a change of direction, where friction shows most."""
    return states.near_reversals()


def reversal_region(parameters: Values, units: Units) -> str:
    """Words for the region in which plain friction shows."""
    return "where the velocity changes sign"


def no_reversal(excitation: Excitation) -> str | None:
    """Reason if there is no reversal: unless the axis rests, friction then is a constant torque."""
    return None if excitation.reversals > 0 else "no reversal of the velocity"


def bristle(position: Array, deflection: float) -> Array:
    """Follow a bristle along a path: -1 to 1, the share of the sliding friction, shape (n,).

    Exact over each piece of the path: dz/dq = (1 - z sign(dq)) / deflection (Dahl, 1968).

    Parameters
    ----------
    position : ndarray (n,)
        In the unit of the deflection.
    deflection : float
        Path over which the bristle comes within 1/e of sliding.
    """
    moves = np.diff(position)
    keeps = np.exp(-np.abs(moves) / deflection).tolist()
    result = np.zeros(len(position))
    state = 0.0
    for index, (move, keep) in enumerate(zip(np.sign(moves).tolist(), keeps, strict=True), 1):
        state = move + (state - move) * keep if move else state
        result[index] = state
    return result


def deflection(words: str, visible: Deflections, typical: Range | None = None) -> EffectParameter:
    """Make the parameter of a visible deflection, within these bounds.

    Parameters
    ----------
    words : str
        What it is.
    visible : callable (Excitation) -> (float, float)
        Its bounds.
    typical : callable (Excitation) -> float, optional
        Its typical size; twice the lower bound unless given.
    """
    return EffectParameter(
        "deflection",
        words,
        "position",
        low=lambda e: visible(e)[0],
        high=lambda e: visible(e)[1],
        scale=typical or (lambda e: 2.0 * visible(e)[0]),
    )


def contact_deflections(excitation: Excitation) -> tuple[float, float]:
    """Deflections of a contact before it slides that can be told from plain sliding."""
    low = max(0.5 * excitation.resolution, _bristle_deflection(excitation))
    most = _CONTACT_ANGLE if excitation.angular else _CONTACT_SHARE * excitation.stroke
    return low, max(most, 10.0 * low)


def body_deflections(excitation: Excitation) -> tuple[float, float]:
    """Bounds of a gear's or cable's deflection: what a contact may deflect, and far more."""
    low, contact = contact_deflections(excitation)
    return low, max(0.2 * excitation.stroke, 20.0 * contact)


def starts(excitation: Excitation, count: int, visible: Deflections) -> list[Values]:
    """Start from `count` deflections, evenly over the logarithm, inside the bounds."""
    low, high = visible(excitation)
    inside = np.geomspace(low, high, count + 2)[1:-1]
    return [{"level": 0.07 * excitation.torque, "deflection": float(value)} for value in inside]


def typical_deflection(states: States) -> float:
    """A deflection that shapes a loop: a fiftieth of the path's range."""
    return 0.02 * max(float(np.ptp(states.position)), np.finfo(float).tiny)
