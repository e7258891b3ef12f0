"""Every effect of the catalogue tried at a probing size: what it changes in the outputs.

The change is simulated through the FMU, so that the loop, the sampling and the twin's own
nonlinearity are in it; it is then regressed on together with the parameters' sensitivities.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted, stacked
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
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
    columns : list of Column
        Change of the signals by each.
    """

    candidate: Candidate
    amplitudes: tuple[str, ...]
    sizes: tuple[float, ...]
    columns: list[Column]

    @property
    def at_probe(self) -> Candidate:
        """The effect with each amplitude at its probing size."""
        sizes = {n: s for n, s in zip(self.amplitudes, self.sizes, strict=True) if n}
        return self.candidate.with_values({**self.candidate.values, **sizes})


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
        return Probe(candidate, ("",), (1.0,), []), [variant]
    share = _TIMING_PROBE if law.family == "timing" else 1.0
    sizes = [share * candidate.values[name] or _PROBE * scales[name] for name in amplitudes]
    variants = []
    for name, size in zip(amplitudes, sizes, strict=True):
        alone = {**dict.fromkeys(amplitudes, 0.0), **shapes, name: size}
        variants.append(replace(base, effects=(*base.effects, candidate.with_values(alone))))
    return Probe(candidate, tuple(amplitudes), tuple(sizes), []), variants


@dataclass(frozen=True, eq=False)
class Screened:
    """How far recordings tell a probe from parameters.

    Attributes
    ----------
    probe : Probe
        What was tried.
    unlike_parameters : float
        Share of the probe's own change that parameters cannot make.
    information : float
        chi2 of that share, at the probing size.
    """

    probe: Probe
    unlike_parameters: float
    information: float


def screened(misfit: Misfit, base: Fitted, probe: Probe) -> Screened:
    """Compare the change that a probe makes with those that parameters make.

    Parameters
    ----------
    misfit : Misfit
        Recordings and noise.
    base : Fitted
        The model about which it was simulated.
    probe : Probe
        What to try.
    """
    made = stacked(misfit, probe.columns)
    total = float(sum(np.sum(more**2) for more in made))
    if not base.x.size or total <= 0.0:
        return Screened(probe, 1.0 if total > 0.0 else 0.0, total)
    own, more = np.concatenate(base.sensitivity, axis=1), np.concatenate(made, axis=1)
    cross = own @ more.T
    explained = cross.T @ np.linalg.lstsq(own @ own.T, cross, rcond=1e-10)[0]
    left = total - float(np.trace(explained))
    return Screened(probe, left / total, left)
