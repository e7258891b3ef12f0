"""Every effect of the catalogue tried at a probing size: what it changes in the outputs.

The change is simulated through the FMU, so that the loop, the sampling and the twin's own
nonlinearity are in it; it is then regressed on together with the parameters' sensitivities.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted, stacked
from gmfbo.diagnosis.fitting.hypothesis import PRIOR_WIDTH, Candidate, Hypothesis
from gmfbo.diagnosis.fitting.linear_left_out import Normal, normal_equations
from gmfbo.diagnosis.fitting.misfit import Misfit

Column = list[tuple[NDArray[np.float64], ...]]
"""Change of the signals, one tuple a recording."""

_PROBE = 0.05  # of a typical size, for amplitudes that start at zero
_TIMING_PROBE = 0.15  # of a start: a delay of 1 ms may already bend the loop's response


@dataclass(frozen=True, eq=False)
class Probe:
    """An effect at one start of its grid, and the columns that it adds to the regression.

    Attributes
    ----------
    candidate : Candidate
        The effect at its start.
    amplitudes : tuple of str
        Parameter that each column is linear in; empty for one that only has a shape.
    sizes : tuple of float
        Value of each at which its column was simulated.
    one_sided : tuple of bool
        The amplitude cannot be negative.
    columns : list of Column
        Change of the signals by each.
    scales : mapping of str to float
        Typical size of each parameter.
    """

    candidate: Candidate
    amplitudes: tuple[str, ...]
    sizes: tuple[float, ...]
    one_sided: tuple[bool, ...]
    columns: list[Column]
    scales: Mapping[str, float] = field(default_factory=dict)

    @property
    def prior(self) -> NDArray[np.float64]:
        """Precision of a weak prior of each column's multiple, shape (n_columns,)."""
        excitation = self.scales
        widths = [
            PRIOR_WIDTH * excitation.get(n, s) / s
            for n, s in zip(self.amplitudes, self.sizes, strict=True)
        ]
        return np.array(widths) ** -2.0

    def scaled(self, shares: NDArray[np.float64]) -> Candidate:
        """Return the effect with each amplitude at this multiple of its probing size."""
        values = dict(self.candidate.values)
        for name, size, share in zip(self.amplitudes, self.sizes, shares, strict=True):
            if name:
                values[name] = size * float(share)
        return self.candidate.with_values(values)


def probes(misfit: Misfit, base: Fitted, candidates: Iterable[Candidate]) -> list[Probe]:
    """Simulate each candidate at its probing size about a fitted model, without noise."""
    planned = [_planned(base.hypothesis, candidate) for candidate in candidates]
    points = [
        hypothesis.point(hypothesis.start(base.parameters))
        for _, variants in planned
        for hypothesis in variants
    ]
    runs = iter(misfit.simulations.run(points))
    found = []
    for probe, variants in planned:
        columns: list[Column] = []
        for _ in variants:
            columns.append(
                [
                    tuple(a - b for a, b in zip(after.signals, before.signals, strict=True))
                    for after, before in zip(next(runs), base.simulated, strict=True)
                ]
            )
        if all(np.isfinite(signal).all() for c in columns for record in c for signal in record):
            found.append(replace(probe, columns=columns))
    return found


def _planned(base: Hypothesis, candidate: Candidate) -> tuple[Probe, list[Hypothesis]]:
    """One variant for each amplitude alone; one in all where there is but a shape."""
    law, excitation = candidate.law, base.setting.excitation
    bounds, scales = law.bounds(excitation), law.scales(excitation)
    amplitudes = [
        name for name, (low, _) in bounds.items() if low <= 0.0 and name in candidate.values
    ]
    shapes = {n: v for n, v in candidate.values.items() if n not in amplitudes}
    if not amplitudes:
        variant = replace(base, effects=(*base.effects, candidate))
        return Probe(candidate, ("",), (1.0,), (True,), [], scales), [variant]
    share = _TIMING_PROBE if law.family == "timing" else 1.0
    sizes = [share * candidate.values[name] or _PROBE * scales[name] for name in amplitudes]
    variants = []
    for name, size in zip(amplitudes, sizes, strict=True):
        alone = {**dict.fromkeys(amplitudes, 0.0), **shapes, name: size}
        variants.append(replace(base, effects=(*base.effects, candidate.with_values(alone))))
    one_sided = tuple(bounds[name][0] == 0.0 for name in amplitudes)
    return Probe(candidate, tuple(amplitudes), tuple(sizes), one_sided, [], scales), variants


@dataclass(frozen=True, eq=False)
class Screened:
    """How much a probe explains of what a fitted model leaves.

    Attributes
    ----------
    probe : Probe
        What was tried.
    kept : tuple of int
        Columns with an admissible sign.
    shares : ndarray, shape (n_columns,)
        Multiple of its probing size at which each fits best; 0 where it was dropped.
    gain : float
        Fall of chi2 on what was left out.
    unlike_parameters : float
        Share of the probe's own change that parameters cannot make.
    information : float
        chi2 of that share, at the probing size.
    """

    probe: Probe
    kept: tuple[int, ...]
    shares: NDArray[np.float64]
    gain: float
    unlike_parameters: float
    information: float


def screen(
    misfit: Misfit, base: Fitted, tried: Sequence[Probe], groups: Sequence[int]
) -> list[Screened]:
    """Regress what a fitted model leaves on each probe, best first.

    Parameters
    ----------
    misfit : Misfit
        Recordings and budget.
    base : Fitted
        The model so far.
    tried : sequence of Probe
        What to try.
    groups : sequence of int
        Group of each window; whole groups are left out together.
    """
    screened = []
    without = normal_equations(base.residual, base.sensitivity, groups, base.prior)
    reference = (float(without.left_out().sum()), float(without.fitted().sum()))
    for probe in tried:
        columns = stacked(misfit, probe.columns)
        screened.append(_screen_one(base, probe, columns, groups, reference))
    return sorted(screened, key=lambda s: -s.gain)


def _screen_one(
    base: Fitted,
    probe: Probe,
    columns: tuple[NDArray[np.float64], ...],
    groups: Sequence[int],
    reference: tuple[float, float],
) -> Screened:
    n_own = base.x.size
    if not all(probe.amplitudes):
        return _screen_shape(base, probe, columns, groups, reference)
    together = tuple(
        np.concatenate([own, more]) for own, more in zip(base.sensitivity, columns, strict=True)
    )
    prior = np.concatenate([base.prior, probe.prior])
    whole = normal_equations(base.residual, together, groups, prior)
    kept = list(range(len(probe.columns)))
    while kept:
        part = whole.only([*range(n_own), *(n_own + i for i in kept)])
        solution = part.solution()[n_own:]
        wrong = [i for i, s in zip(kept, solution, strict=True) if probe.one_sided[i] and s <= 0.0]
        if not wrong:
            shares = np.zeros(len(probe.columns))
            shares[kept] = solution
            gain = _gain(reference, part)
            return Screened(probe, tuple(kept), shares, gain, *_unlike(part, n_own))
        kept.remove(wrong[0])
    share, information = _unlike(whole, n_own)
    return Screened(probe, (), np.zeros(len(probe.columns)), 0.0, share, information)


def _gain(reference: tuple[float, float], normal: Normal) -> float:
    """Fall of the square on what was left out, or on all where that is less.

    The former alone varies by a hundred under noise, where one group carries most information.
    """
    left_out = reference[0] - float(normal.left_out().sum())
    return min(left_out, reference[1] - float(normal.fitted().sum()))


def _screen_shape(
    base: Fitted,
    probe: Probe,
    columns: tuple[NDArray[np.float64], ...],
    groups: Sequence[int],
    reference: tuple[float, float],
) -> Screened:
    """A limit has no size to scale: it is tried as it stands, the parameters refitted."""
    residual = tuple(r - c[0] for r, c in zip(base.residual, columns, strict=True))
    without = normal_equations(residual, base.sensitivity, groups, base.prior)
    together = tuple(
        np.concatenate([own, more]) for own, more in zip(base.sensitivity, columns, strict=True)
    )
    whole = normal_equations(base.residual, together, groups)
    gain = _gain(reference, without)
    return Screened(probe, (0,), np.ones(1), gain, *_unlike(whole, base.x.size))


def _unlike(normal: Normal, n_own: int) -> tuple[float, float]:
    """Share and square of the columns' change that parameters' sensitivities cannot make."""
    g = normal.matrix.sum(axis=0)
    own, cross, more = g[:n_own, :n_own], g[:n_own, n_own:], g[n_own:, n_own:]
    total = float(np.trace(more))
    if not n_own or total <= 0.0:
        return (1.0 if total > 0.0 else 0.0), total
    explained = cross.T @ np.linalg.lstsq(own, cross, rcond=1e-10)[0]
    left = float(np.trace(more - explained))
    return left / total, left
