"""From which size on effects are named: a logistic curve over the logarithm of the gain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit

from tests.blind.hidden import EFFECTS
from tests.blind.score import Scored

_LEAST_GAIN = 0.1
_WEAK = 0.01
"""Precision of the prior that keeps the curve finite where the classes do not overlap."""


def logistic(gains: Sequence[float], named: Sequence[bool]) -> tuple[float, float]:
    """Intercept and slope of the log odds of a name over log10(gain).

    Parameters
    ----------
    gains : sequence of float
        Oracle gains.
    named : sequence of bool
        Whether each was named right.
    """
    x = np.log10(np.maximum(gains, _LEAST_GAIN))
    y = np.asarray(named, dtype=float)

    def loss(p: NDArray[np.float64]) -> float:
        odds = p[0] + p[1] * x
        return float(np.sum(np.logaddexp(0.0, odds) - y * odds) + _WEAK * np.sum(p**2))

    def slope(p: NDArray[np.float64]) -> NDArray[np.float64]:
        off = expit(p[0] + p[1] * x) - y
        return np.array([np.sum(off), np.sum(off * x)]) + 2.0 * _WEAK * p

    found = minimize(loss, np.array([-2.0, 1.0]), jac=slope, method="BFGS").x
    return float(found[0]), float(found[1])


def gain_at(share: float, curve: tuple[float, float]) -> float:
    """Oracle gain at which this share is named; infinite where the curve does not rise."""
    if curve[1] <= 0.0:
        return float("inf")
    exponent = (np.log(share / (1.0 - share)) - curve[0]) / curve[1]
    return float(10.0 ** min(exponent, 12.0))


def limits(scores: Sequence[Scored]) -> str:
    """Text: oracle gain at 50 and 90 % naming, for all single effects and by port."""
    singles = [s for s in scores if s.kind == "single" and s.within_reach]
    lines = [f"{'single effects':<20}{'cases':>6}{'50 %':>10}{'90 %':>10}"]
    for title in ("all", "torque", "command", "sensor"):
        chosen = [s for s in singles if title in ("all", EFFECTS[s.hidden[0]].port)]
        if len(chosen) < 4 or len({s.outcome == "right" for s in chosen}) < 2:
            lines.append(f"{title:<20}{len(chosen):>6}{'-':>10}{'-':>10}")
            continue
        curve = logistic([s.gain for s in chosen], [s.outcome == "right" for s in chosen])
        cells = "".join(f"{_shown(gain_at(share, curve)):>10}" for share in (0.5, 0.9))
        lines.append(f"{title:<20}{len(chosen):>6}{cells}")
    return "Oracle gain at which effects are named right (logistic fit)\n" + "\n".join(lines)


def _shown(gain: float) -> str:
    return f"{gain:.3g}" if gain < 1e6 else "> 1e6"
