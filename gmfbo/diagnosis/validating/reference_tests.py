"""Test whether a model's residual still follows the reference.

In closed loop, noise reaches every signal but the reference, so the residual of a right model is
uncorrelated with the reference (Ljung 1999, System Identification, section 16.6), and with its
direction of motion, for nonlinear axes (Billings, Voon 1986).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.result.curve import Curve
from gmfbo.diagnosis.result.reference_test import ResidualTest
from gmfbo.diagnosis.scoring.long_run_covariance import long_run_covariance
from gmfbo.diagnosis.scoring.noise_levels import POSITION_TOLERANCE, TOLERANCE

Array = NDArray[np.float64]

_BY_CHANCE = 0.99
_FEW_ROWS = 64
_DIFFERENT = 0.02  # of the strongest direction; weaker ones are rounding errors


def residual_tests(
    case: Case,
    curves: Sequence[Curve],
    scored: Mapping[str, tuple[float, float]],
    model: Fitted,
) -> tuple[ResidualTest, ...]:
    """Test every signal of the held-out stretches.

    Parameters
    ----------
    case : Case
        Of these recordings.
    curves : sequence of Curve
        Recorded and simulated signals.
    scored : mapping of str to (float, float)
        [s] Stretch of each recording that had no part in the fit.
    model : Fitted
        The final one; what half its step changes in it is no missing physics.
    """
    found = []
    drives, steps = _drives(case), _step_errors(case, model)
    position = case.twin.file.states.get("position")
    variables = case.twin.binding.variables
    length = variables[position].variable.si_unit if position else None
    for curve in curves:
        if curve.recording not in scored or curve.recording not in drives:
            continue
        time, values = drives[curve.recording]
        final = curve.augmented if np.isfinite(curve.augmented).any() else curve.parameters_only
        share = POSITION_TOLERANCE if curve.unit == length else TOLERANCE
        reference = np.interp(curve.time, time, values)
        own = steps.get((curve.recording, curve.signal), (curve.time, np.zeros(curve.time.size)))
        error = np.interp(curve.time, *own)
        tested = _tested(curve, reference, final, share, scored[curve.recording], error)
        if tested is not None:
            found.append(tested)
    return tuple(found)


def _drives(case: Case) -> Mapping[str, tuple[Array, Array]]:
    """Time [s] and values of the first input that moves, for each recording."""
    drives = {}
    for record in case.simulations.records:
        recording = record.plan.recording
        for name in case.twin.file.inputs:
            if name not in recording.signals:
                continue
            values = recording.signal(name)
            known = np.isfinite(values)
            if known.any() and np.ptp(values[known]) > 0.0:
                drives[record.name] = (recording.time[known], values[known])
                break
    return drives


def _step_errors(case: Case, model: Fitted) -> dict[tuple[str, str], tuple[Array, Array]]:
    """Times [s] and change [SI] of each recording's signals at half the twin's step."""
    simulations, point = case.simulations, model.hypothesis.point(model.x)
    changes = simulations.step_errors(point, simulations.run([point])[0])
    return {
        (record.name, signal.name): (signal.time, change)
        for record, own in zip(simulations.records, changes, strict=True)
        for signal, change in zip(record.signals, own or (), strict=own is not None)
    }


def _tested(
    curve: Curve,
    reference: Array,
    final: Array,
    tolerated: float,
    stretch: tuple[float, float],
    error: Array,
) -> ResidualTest | None:
    known = np.isfinite(curve.recorded) & np.isfinite(curve.parameters_only) & np.isfinite(final)
    known &= (curve.time >= stretch[0]) & (curve.time <= stretch[1])
    extent = float(np.ptp(curve.recorded[known])) if known.any() else 0.0
    if np.count_nonzero(known) < _FEW_ROWS or extent <= 0.0 or np.ptp(reference[known]) == 0.0:
        return None
    columns = reference_columns(curve.time, reference)[:, known]
    left = (curve.recorded - final)[known]
    follows, rest = following_part(columns, left)
    known_part, _ = following_part(columns, error[known])
    before, _ = following_part(columns, (curve.recorded - curve.parameters_only)[known])
    return ResidualTest(
        curve.recording,
        curve.signal,
        before / extent,
        follows / extent,
        float(np.hypot(chance_bound(columns, rest), known_part)) / extent,
        tolerated * float(np.sqrt(np.mean(curve.recorded[known] ** 2))) / extent,
    )


def reference_columns(time: Array, reference: Array) -> Array:
    """Orthogonal directions by the reference, each of RMS one, that a residual may follow.

    They span the reference, its rate, its acceleration and its direction, shape (n, rows).

    Parameters
    ----------
    time : ndarray, shape (rows,)
        [s]
    reference : ndarray, shape (rows,)
        Values of the reference.
    """
    rate = np.gradient(reference, time)
    # A reference slower than a thousandth of its highest speed is at rest: no direction.
    turning = np.tanh(rate / max(1e-3 * float(np.abs(rate).max()), 1e-300))
    columns = np.stack([reference, rate, np.gradient(rate, time), turning])
    columns -= columns.mean(axis=1, keepdims=True)
    size = np.sqrt(np.mean(columns**2, axis=1))
    known = size > 1e-9 * float(size.max())
    _, share, directions = np.linalg.svd(columns[known] / size[known, None], full_matrices=False)
    # The acceleration of a sine is the reference again, but for rounding at its ends. A direction
    # of so few rows would fit their noise.
    scaled: Array = directions[share > _DIFFERENT * share[0]] * np.sqrt(time.size)
    return scaled


def following_part(columns: Array, left: Array) -> tuple[float, Array]:
    """RMS of the part of a residual along the columns, and the rest of the residual.

    Parameters
    ----------
    columns : ndarray, shape (n, rows)
        Orthogonal directions.
    left : ndarray, shape (rows,)
        The residual; its mean is ignored.
    """
    centred = left - left.mean()
    made = np.linalg.lstsq(columns.T, centred, rcond=None)[0] @ columns
    return float(np.sqrt(np.mean(made**2))), centred - made


def chance_bound(columns: Array, rest: Array) -> float:
    """RMS along the columns that coloured noise exceeds once in a hundred times.

    The power along the columns is a quadratic form of normal variables with the covariance of
    Newey and West (1987). Its quantile is taken from a scaled chi2 with the same mean and variance
    (Satterthwaite 1946).

    Parameters
    ----------
    columns : ndarray, shape (n, rows)
        Orthogonal directions.
    rest : ndarray, shape (rows,)
        Residual without its part along the columns, taken as coloured noise.
    """
    rows = rest.size
    covariance = long_run_covariance(columns / np.sqrt(rows) * rest)
    powers = np.maximum(np.linalg.eigvalsh(covariance), 0.0)
    if powers.sum() <= 0.0:
        return 0.0
    scale = float(np.sum(powers**2) / powers.sum())
    freedom = float(powers.sum() ** 2 / np.sum(powers**2))
    return float(np.sqrt(2.0 * scale * gammaincinv(0.5 * freedom, _BY_CHANCE) / rows))
