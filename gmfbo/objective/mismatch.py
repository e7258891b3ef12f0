"""Mismatch of the twin, and its effect on the surrogate and the query cost.

Two measures of the same pairs (objective of the corrected twin g_c, of the twin g_2, equal
gains), both fractions, not percent:

- `relative_mismatch`, as published (equations 9, 12, 13): mean |g_c - g_2| / |g_c|. After
  normalising, g crosses zero, and single pairs can dominate the mean.
- `scaled_mismatch`: median |G_c - G_2| / G_c on G = sum w_i h_i / std_i, which is not shifted
  and so never negative.

l_g0 = clamp(1 / e, 0.1, 1) and H(IS2) = clamp(e, 0.1, 1).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gmfbo.errors import InputError

SOURCE_LENGTHSCALE_BOUNDS = (0.1, 1.0)
QUERY_COST_BOUNDS = (0.1, 1.0)
# |g_c| below this share of the spread of all |g_c| counts as that share: a guard that is not in
# the publication.
LEAST_SHARE = 1e-6


def relative_mismatch(corrected: ArrayLike, twin: ArrayLike) -> float:
    """e = mean |g_c - g_2| / |g_c| over pairs of shape (n,); 1 without any pair."""
    g_c, g_2 = _pairs(corrected, twin)
    if g_c.size == 0:
        return 1.0
    return float(np.mean(np.abs(g_c - g_2) / _guarded(g_c)))


def scaled_mismatch(corrected: ArrayLike, twin: ArrayLike) -> float:
    """e = median |G_c - G_2| / G_c over pairs of shape (n,); 1 without any pair.

    Parameters
    ----------
    corrected, twin : array_like, shape (n,)
        Scaled, non-negative objectives G of corrected twin and twin at the same gains.

    Raises
    ------
    InputError
        A value is negative, so it is g, not G.
    """
    g_c, g_2 = _pairs(corrected, twin)
    if g_c.size == 0:
        return 1.0
    if min(g_c.min(), g_2.min()) < 0.0:
        raise InputError(
            "expected scaled objectives G, which are not negative; "
            "give Objective.scaled values, not g"
        )
    return float(np.median(np.abs(g_c - g_2) / _guarded(g_c)))


def source_lengthscale(mismatch: float) -> float:
    """l_g0 = clamp(1 / e, 0.1, 1), as in the publication."""
    low, cap = SOURCE_LENGTHSCALE_BOUNDS
    # e <= 1 / cap covers e = 0, where 1 / e is infinite.
    return cap if mismatch * cap <= 1.0 else max(1.0 / mismatch, low)


def query_cost(mismatch: float) -> float:
    """H(IS2) = clamp(e, 0.1, 1), in units of a run of the axis."""
    return float(np.clip(mismatch, *QUERY_COST_BOUNDS))


def _pairs(corrected: ArrayLike, twin: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    g_c, g_2 = np.asarray(corrected, dtype=float), np.asarray(twin, dtype=float)
    if g_c.ndim != 1 or g_c.shape != g_2.shape:
        raise InputError(f"expected pairs of objectives, got shapes {g_c.shape} and {g_2.shape}")
    if not (np.all(np.isfinite(g_c)) and np.all(np.isfinite(g_2))):
        raise InputError("objectives hold NaN or infinity; price failed runs before comparing")
    return g_c, g_2


def _guarded(g_c: np.ndarray) -> np.ndarray:
    largest = float(np.abs(g_c).max())
    floor = LEAST_SHARE * largest if largest > 0.0 else 1.0
    return np.asarray(np.maximum(np.abs(g_c), floor))
