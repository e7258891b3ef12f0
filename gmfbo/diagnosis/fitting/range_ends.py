"""Parameters of a twin at the ends of the ranges that its file gives."""

from __future__ import annotations

from collections.abc import Mapping

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.result.estimated import Side

_NEAR = 0.01
"""Of a range. A trust-region-reflective step ends off a bound by up to 0.005 of its own length
(SciPy's `least_squares`; Branch, Coleman, Li 1999): twice that is still at the bound."""


def ends_reached(fitted: Fitted, ranges: Mapping[str, tuple[float, float]]) -> dict[str, Side]:
    """Parameters that lie beyond an end of their range, or at it with chi2 falling outward.

    At a bound that holds a fit, the gradient of chi2 points out of the range (the sign of its
    Lagrange multiplier), and a Gauss-Newton step of that parameter alone would cross the bound.

    Parameters
    ----------
    fitted : Fitted
        The twin refitted, with or without effects.
    ranges : mapping of str to (float, float)
        [FMU's unit] Range of each uncertain parameter.
    """
    found: dict[str, Side] = {}
    for i, uncertain in enumerate(fitted.hypothesis.setting.uncertain):
        if uncertain.name not in ranges:
            continue  # freed by a hypothesis
        low, high = ranges[uncertain.name]
        step = _own_step(fitted, i)
        for side, outside, outward in (
            ("low", low - fitted.x[i], -step),
            ("high", fitted.x[i] - high, step),
        ):
            is_held = outside >= -_NEAR * (high - low) and outward >= -outside
            if outside > 0.0 or is_held:
                found[uncertain.name] = "low" if side == "low" else "high"
    return found


def _own_step(fitted: Fitted, place: int) -> float:
    """Gauss-Newton step of one parameter, the others kept."""
    pairs = list(zip(fitted.sensitivity, fitted.residual, strict=True))
    curvature = sum(float(own[place] @ own[place]) for own, _ in pairs)
    slope = sum(float(own[place] @ left) for own, left in pairs)
    return slope / curvature if curvature > 0.0 else 0.0
