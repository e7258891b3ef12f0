"""How large a hidden effect is to be, so that the oracle gains what was drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from tests.blind.hidden import Changes, Hidden, Rng, Setting
from tests.blind.oracle import Oracle
from tests.blind.truth import Diverged

BANDS = {"below": (1.5, 15.0), "around": (15.0, 250.0), "above": (250.0, 1e4)}
"""Oracle gains of single effects, in the units of a decision threshold of about 15."""

CLEAR_BANDS = {"pair": (300.0, 1e4), "outside": (1e3, 1e5)}
"""The same for kinds that ask another question than that of the limit."""

OWED_BAND = {"owed": (80.0, 1e4)}
"""Band of a draw whose names are all owed: above 60, where the full refit gains a little less."""

_EVALUATIONS = 8
_NOTHING = 1e-4
_CLOSE = 1.25
"""Factor within which a gain is the one that was drawn."""


def target_gain(kind: str, band: str, rng: Rng) -> float:
    """Gain that a hidden effect is sized for, log-uniform in its band."""
    low, high = np.log(CLEAR_BANDS[kind] if kind in CLEAR_BANDS else {**BANDS, **OWED_BAND}[band])
    return float(np.exp(rng.uniform(low, high)))


def size_for_gain(
    hidden: Hidden,
    shaped: Callable[[float], Changes],
    setting: Setting,
    oracle: Oracle,
    target: float,
) -> float:
    """Size at which the oracle gains about `target`, within what is plausible.

    Small effects gain by the square of their size: the next trial follows from that, within the
    sizes known to be too small and too large. A plant that no longer follows, and swings to twice
    what was asked, is not plausible.
    """
    low, high = float(np.log(hidden.low(setting))), float(np.log(hidden.high(setting)))
    reach = [2.0 * float(np.max(np.abs(run.position))) for run in oracle.clean]
    known: dict[float, float] = {}  # logarithms of gain over target by logarithm of size
    at = 0.5 * (low + high)
    for _ in range(_EVALUATIONS):
        gain = _plausible_gain(oracle, shaped(float(np.exp(at))), reach)
        if gain is not None and gain > _NOTHING * target:
            known[at] = float(np.log(gain / target))
            if abs(known[at]) < np.log(_CLOSE):
                return _rounded(at)
        if gain is not None and gain < target:
            low = at
        else:
            high = at
        at = _next(low, high, known)
    return _rounded(low)


def _next(low: float, high: float, known: Mapping[float, float]) -> float:
    """By the line between both ends, by the square from one of them, or the middle."""
    if low in known and high in known:
        guess = low + (high - low) * known[low] / (known[low] - known[high])
    elif low in known:
        guess = low - 0.5 * known[low]
    elif high in known:
        guess = high - 0.5 * known[high]
    else:
        guess = 0.5 * (low + high)
    margin = 0.1 * (high - low)
    return float(np.clip(guess, low + margin, high - margin))


def _plausible_gain(oracle: Oracle, changes: Changes, reach: Sequence[float]) -> float | None:
    try:
        runs, means = oracle.runs(changes), oracle.means(changes)
    except Diverged:
        return None
    if any(np.max(np.abs(run.position)) > most for run, most in zip(runs, reach, strict=True)):
        return None
    return oracle.quick_gain(means)


def _rounded(log_size: float) -> float:
    return float(f"{np.exp(log_size):.4g}")
