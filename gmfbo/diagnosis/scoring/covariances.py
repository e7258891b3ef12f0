"""Covariance S(f) of each window, from its parts, and the resulting whiteners."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.diagnosis.scoring.noise_levels import (
    excess_of_repeats,
    loop_covariance,
    tolerance_covariance,
    white_covariance,
)
from gmfbo.diagnosis.scoring.nuisances import Direction
from gmfbo.diagnosis.scoring.signal_parts import Rig
from gmfbo.diagnosis.scoring.whitening import Spectrum, Whitener, Window
from gmfbo.diagnosis.scoring.windows import starts_apart


def covariances(
    windows: Sequence[Window],
    records: Sequence[Record],
    rig: Rig,
    own: Sequence[Sequence[float]],
    loop_noise: Sequence[Sequence[Direction]],
) -> list[Spectrum]:
    """S(f) of each window: loop noise, own noise, repeats, tolerance.

    Parameters
    ----------
    windows : sequence of Window
        Stretches that are scored.
    records : sequence of Record
        Recordings that are scored.
    rig : Rig
        Roles of the signals.
    own : sequence of sequences of float
        [SI unit squared] Variance of each signal's own noise, for each recording.
    loop_noise : sequence of sequences of Direction
        Changes of each recording's signals under noise.
    """
    total = []
    for window in windows:
        record = records[window.record]
        white = white_covariance(window, own[window.record])
        s = white + loop_covariance(window, loop_noise[window.record])
        s = s + _repeats(window, records, s, rig.positions)
        total.append(s + tolerance_covariance(window, record, rig.positions))
    return total


def noise_squares(
    windows: Sequence[Window], records: Sequence[Record], rig: Rig, spectra: Sequence[Spectrum]
) -> tuple[float, ...]:
    """chi2 of each window by noise alone, without the tolerance that S(f) also holds.

    Parameters
    ----------
    windows : sequence of Window
        Stretches that are scored.
    records : sequence of Record
        Recordings that are scored.
    rig : Rig
        Roles of the signals.
    spectra : sequence of ndarray
        S(f) of each window.
    """
    found = []
    for window, s in zip(windows, spectra, strict=True):
        tolerance = tolerance_covariance(window, records[window.record], rig.positions)
        shares = 1.0 - np.real(np.einsum("fij,fji->f", np.linalg.inv(s), tolerance)) / s.shape[1]
        size = Whitener(window, s).n_residuals
        weights = np.mean(window.seen, axis=1)
        found.append(size * float(np.clip(np.sum(shares * weights) / np.sum(weights), 0.01, 1.0)))
    return tuple(found)


def _repeats(
    window: Window, records: Sequence[Record], known: Spectrum, positions: Collection[str]
) -> Spectrum | float:
    first = records[window.record]
    excess = []
    for k, other in enumerate(records):
        if k == window.record or not _same_experiment(first, other):
            continue
        if [s.name for s in first.signals] != [s.name for s in other.signals]:
            continue
        if not _starts_apart(first, other, positions):
            excess.append(excess_of_repeats(window, first, other, known))
    return sum(excess) / len(excess) if excess else 0.0


def _same_experiment(a: Record, b: Record) -> bool:
    one, two = a.plan.experiment, b.plan.experiment
    if one.parameters.in_force != two.parameters.in_force or one.grid.size != two.grid.size:
        return False
    return one.inputs.keys() == two.inputs.keys() and all(
        np.allclose(one.inputs[name], two.inputs[name], rtol=0.0, atol=1e-12) for name in one.inputs
    )


def _starts_apart(a: Record, b: Record, positions: Collection[str]) -> bool:
    """Whether two recordings begin at different places: let go from there, they are no repeats."""
    return any(
        one.name in positions and starts_apart(one, two.values)
        for one, two in zip(a.signals, b.signals, strict=True)
    )


def whiteners(
    windows: Sequence[Window],
    spectra: Sequence[Spectrum],
    directions: Sequence[Sequence[Direction]],
    dispersion: Sequence[NDArray[np.float64]] | None = None,
) -> tuple[Whitener, ...]:
    """Whiteners of the windows, from budget and nuisances.

    Parameters
    ----------
    windows : sequence of Window
        Stretches that are scored.
    spectra : sequence of ndarray
        S(f) of each window.
    directions : sequence of sequences of Direction
        Nuisances of each recording.
    dispersion : sequence of ndarray, optional
        Factor by which each window's components exceed the budget.
    """
    spread = [None] * len(windows) if dispersion is None else dispersion
    return tuple(
        Whitener(window, s, dispersion=d).without(directions[window.record])
        for window, s, d in zip(windows, spectra, spread, strict=True)
    )
