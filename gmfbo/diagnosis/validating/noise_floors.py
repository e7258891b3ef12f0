"""Error of a signal that noise alone makes, at the levels that the comparison has found."""

from __future__ import annotations

import numpy as np

from gmfbo.diagnosis.comparison.held_out_fit import Part
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.noise.places import covariance

_BINS = 2048  # most frequencies: a resonance of the loop is wider


def noise_floors(part: Part, ledger: Ledger) -> dict[str, float]:
    """[SI] Rms error of each signal by noise, and by what rows leave open.

    Noise is what the controller reads, the logger adds and its clock: by Parseval's theorem the
    mean of its spectrum over all frequencies. Beside it is what an input between its rows and slow
    rounding most likely made.

    Parameters
    ----------
    part : Part
        A model on the stretches that are scored.
    ledger : Ledger
        Levels of noise, and its paths there.
    """
    nothing = dict.fromkeys(set(ledger.levels.ports) - {"sensor"}, 0.0)
    levels = ledger.levels.with_missing(**nothing)
    squares: dict[str, float] = {}
    rows: dict[str, int] = {}
    rates = part.problem.rates(part.fitted.values)
    errors = ledger.errors.of_rows
    left = errors.taken_out(part.problem, part.fitted, ledger.kernels, ledger.levels)
    made = [a - b for a, b in zip(part.fitted.residual, left.residual, strict=True)]
    for segment, rate, error in zip(part.problem.segments, rates, made, strict=True):
        n, kernels = segment.time.size, ledger.kernels.of(segment.record)
        bins = np.linspace(0.0, 0.5 / segment.spacing, min(n // 2, _BINS) + 1)
        spectra = covariance(levels, kernels, segment.names, bins, (rate**2).mean(1))
        power = np.einsum("fii->fi", spectra).real.mean(0)
        power = power + (error**2).mean(1)
        for name, square in zip(segment.names, power, strict=True):
            squares[name] = squares.get(name, 0.0) + n * float(square)
            rows[name] = rows.get(name, 0) + n
    return {name: float(np.sqrt(total / rows[name])) for name, total in squares.items()}
