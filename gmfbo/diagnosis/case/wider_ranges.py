"""Ranges of the twin's parameters that recordings contradict, and values beyond them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from gmfbo.diagnosis.case.case import Case, chi2_per_dof, is_more_than_noise, times_noise
from gmfbo.diagnosis.case.other_starts import FAR, STARTS
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.fitting.misfit import chi2
from gmfbo.diagnosis.fitting.range_ends import ends_reached
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.uncertain import Uncertain

_DECADE = 10.0  # by which starts lie beyond the ends of a range: axes of one series differ by less
_EXPLAINED = 0.5  # of the misfit beyond noise: wider ranges that leave more explain nothing


@dataclass(frozen=True)
class WiderRanges:
    """Ranges that hold values which the recordings ask for.

    Attributes
    ----------
    ranges : mapping of str to (float, float)
        [FMU's unit] New range of each parameter whose own is too narrow.
    values : mapping of str to float
        [FMU's unit] Uncertain parameters there, as the start of a fit.
    """

    ranges: Mapping[str, tuple[float, float]]
    values: Mapping[str, float]


def wider_ranges(case: Case) -> WiderRanges | None:
    """Look beyond the ranges of parameters for what these leave of the recordings.

    A range that is too narrow looks like missing physics. It is looked beyond where a bound holds
    the fit, and from other starts where the fit stays far from the recordings. The signs of
    ranges and the FMU's own limits are kept.

    Parameters
    ----------
    case : Case
        With the fit within the ranges.

    Returns
    -------
    WiderRanges or None
        None where the ranges explain the recordings to the noise, or where values beyond them
        leave more than half of what the ranges leave beyond noise.
    """
    base = case.base
    if not base.x.size or not is_more_than_noise(case, base):
        return None
    stated = stated_ranges(case.twin)
    wide = tuple(_widened(u, case.twin) for u in case.setting.uncertain)
    hypothesis = Hypothesis(replace(case.setting, uncertain=wide))
    starts: list[Mapping[str, float]] = []
    if ends_reached(base, stated):
        starts.append(base.parameters)
    if chi2_per_dof(base, case.misfit) > FAR:
        starts.append(_best_start(case, hypothesis))
    fits = [fit(case.misfit, hypothesis, start, parallel=True) for start in starts]
    best = min((f for f in fits if f is not None), key=lambda f: f.chi2, default=None)
    if best is None or times_noise(case, best) - 1.0 > _EXPLAINED * (times_noise(case, base) - 1.0):
        return None
    return WiderRanges(_that_hold(best, stated), best.parameters)


def stated_ranges(twin: FmuTwin) -> dict[str, tuple[float, float]]:
    """Ranges [FMU's unit] of the uncertain parameters in the twin file, within the FMU's limits."""
    return {
        name: _within_limits(twin, name, low, high)
        for name, (low, high) in twin.file.uncertain.items()
    }


def _within_limits(twin: FmuTwin, name: str, low: float, high: float) -> tuple[float, float]:
    variable = twin.binding.variables[name].variable
    least = -np.inf if variable.minimum is None else variable.minimum
    most = np.inf if variable.maximum is None else variable.maximum
    return float(max(low, least)), float(min(high, most))


def _widened(uncertain: Uncertain, twin: FmuTwin) -> Uncertain:
    """The parameter with a range whose ends lie a decade further out; signs stay."""
    low = uncertain.low * (_DECADE if uncertain.low < 0.0 else 1.0 / _DECADE)
    high = uncertain.high * (_DECADE if uncertain.high > 0.0 else 1.0 / _DECADE)
    low, high = _within_limits(twin, uncertain.name, low, high)
    return replace(uncertain, low=low, high=high)


def _best_start(case: Case, hypothesis: Hypothesis) -> dict[str, float]:
    """The best of a few points spread over ranges, evenly in the logarithm of each size."""
    low, high = hypothesis.bounds
    shares = qmc.Sobol(low.size, scramble=False).random(STARTS)
    starts = [hypothesis.inside(_between(low, high, row)) for row in shares]
    found = case.simulations.run([hypothesis.point(x) for x in starts])
    squares = [
        chi2(case.misfit.residual(runs)) if all(run.finite for run in runs) else np.inf
        for runs in found
    ]
    return hypothesis.parameters(starts[int(np.argmin(squares))])


def _between(
    low: NDArray[np.float64], high: NDArray[np.float64], shares: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Values at these shares of ranges; of one that begins at zero its last two decades count."""
    values = low + shares * (high - low)
    for i, (a, b) in enumerate(zip(low, high, strict=True)):
        near, far = sorted((abs(a), abs(b)))
        if a * b >= 0.0 and far > 0.0:
            near = near or far / _DECADE**2
            values[i] = np.copysign(near * (far / near) ** shares[i], a + b)
    return values


def _that_hold(
    best: Fitted, stated: Mapping[str, tuple[float, float]]
) -> dict[str, tuple[float, float]]:
    """Ranges that reach twice as far beyond their ends as the values found there, signs kept."""
    wide = {u.name: (u.low, u.high) for u in best.hypothesis.setting.uncertain}
    ranges = {}
    for name, side in ends_reached(best, stated).items():
        (low, high), value = stated[name], best.parameters[name]
        if side == "low":
            ranges[name] = (max(2.0 * value - low, wide[name][0]), high)
        else:
            ranges[name] = (low, min(2.0 * value - high, wide[name][1]))
    return ranges
