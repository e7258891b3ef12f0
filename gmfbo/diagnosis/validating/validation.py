"""Validate the augmented twin on held-out recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.held_out_split import Split, restricted, rows_of
from gmfbo.diagnosis.fitting.fit import Fitted, fit, fit_to_the_end
from gmfbo.diagnosis.fitting.misfit import Misfit, chi2
from gmfbo.diagnosis.noise.replayed_noise import under_noise, without_noise
from gmfbo.diagnosis.result.curve import Curve
from gmfbo.diagnosis.result.held_out_errors import Fit, SignalFit, contradicts_names
from gmfbo.diagnosis.runs.simulated import Simulated

_CLEARLY = 15.0  # fall of chi2 that absent physics does not reach; 8 in one sound twin
_DIFFERENT = 4.0  # squared distance of two models, whitened: two standard deviations of noise


@dataclass(frozen=True, eq=False)
class Validated:
    """Models fitted on some recordings, scored on others.

    Attributes
    ----------
    fit : Fit
        Table of errors.
    curves : tuple of Curve
        Recorded and simulated signals of all recordings.
    scored : mapping of str to (float, float)
        [s] Scored stretch of each recording; infinite ends for a whole recording.
    parameters_only, augmented : Fitted
        The twin with its parameters refitted, without and with the named physics; the same where
        nothing was named.
    misfit : Misfit
        Misfit by which both were fitted.
    contradicts_names : bool
        Whether held-out recordings contradict the named physics, with replayed noise where that
        matters to the model.
    """

    fit: Fit
    curves: tuple[Curve, ...]
    scored: Mapping[str, tuple[float, float]]
    parameters_only: Fitted
    augmented: Fitted
    misfit: Misfit
    contradicts_names: bool


def validate(
    case: Case,
    model: Fitted,
    split: Split,
    unnamed: Sequence[Sequence[NDArray[np.float64]]] | None,
    least: float = np.inf,
) -> Validated:
    """Refit on the fitted windows alone, and score on the others.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    model : Fitted
        The twin with all named physics, where the refit starts.
    split : Split
        Which windows are fitted.
    unnamed : sequence of sequences of ndarray, optional
        Change of each recording's signals by a model without a name.
    least : float
        chi2 per degree of freedom with the whole library fitted: an upper bound of the noise floor
        of the removed share, since error budgets are generous.
    """
    chosen = split.fitted or tuple(range(len(case.budget.windows)))
    misfit = restricted(case.misfit, chosen)
    plain = _refitted(misfit, case.base)
    augmented = _refitted(misfit, model) if model.hypothesis.effects else plain
    scored = split.held_out or chosen
    return _scored(case, misfit, scored, plain, augmented, model, split, unnamed, least)


def validate_unseen(case: Case, unseen: Case, model: Fitted, least: float = np.inf) -> Validated:
    """Score models of some recordings on others that had no part in any fit.

    Parameters
    ----------
    case : Case
        Twin and the recordings that were fitted.
    unseen : Case
        The same twin and the other recordings.
    model : Fitted
        The twin with all named physics.
    least : float
        As of `validate`.
    """
    split = Split(
        tuple(range(len(case.budget.windows))),
        tuple(range(len(unseen.budget.windows))),
        tuple(record.name for record in case.simulations.records),
        tuple(record.name for record in unseen.simulations.records),
    )
    if not model.converged:
        model = _refitted(case.misfit, model)
    # Found while the effects were decided, after these recordings had been opened.
    unseen.simulations.begins_at_rest = case.simulations.begins_at_rest
    there = [
        _measured(unseen.misfit, replace(fitted, hypothesis=fitted.hypothesis.quiet))
        for fitted in (case.base, model)
    ]
    if model.hypothesis.noise is not None:
        noisy = under_noise(unseen.misfit, there[1])
        if noisy is not None:
            shaken = replace(there[1], hypothesis=noisy)
            there[1] = _measured(unseen.misfit, shaken)
    held_out = split.held_out
    result = _scored(
        unseen, case.misfit, held_out, there[0], there[1], there[1], split, None, least
    )
    return replace(result, parameters_only=case.base, augmented=model)


def _scored(
    case: Case,
    fitted_by: Misfit,
    scored: Sequence[int],
    plain: Fitted,
    augmented: Fitted,
    best: Fitted,
    split: Split,
    unnamed: Sequence[Sequence[NDArray[np.float64]]] | None,
    least: float,
) -> Validated:
    fall, distance = _change(case, scored, plain, augmented)
    differs = distance > _DIFFERENT
    removed = None
    if differs:
        removed = _removed(case, scored, plain, augmented, best, least)
    shown = [without_noise(case.simulations, model) for model in (case.base, plain, augmented)]
    signals = _table(case, scored, shown[0], shown[1], shown[2], unnamed)
    table = Fit(split.names_fitted, split.names_held_out, signals, removed)
    curves = _curves(case, shown[1], shown[2])
    judged = table
    if augmented.hypothesis.noise is not None:
        # Without noise an axis may stick where the real one moves: no sign of a wrong law.
        judged = replace(table, signals=_table(case, scored, case.base, plain, augmented, unnamed))
    stretches = _stretches(case, scored)
    contradicts = contradicts_names(judged, falls=fall > _CLEARLY, differs=differs)
    return Validated(table, curves, stretches, plain, augmented, fitted_by, contradicts)


def _change(
    case: Case, scored: Sequence[int], plain: Fitted, augmented: Fitted
) -> tuple[float, float]:
    """Fall of the whitened squared error by the physics, and squared distance of both models."""
    misfit = restricted(case.plain, scored)
    before, after = (misfit.residual(fitted.simulated) for fitted in (plain, augmented))
    distance = tuple(a - b for a, b in zip(before, after, strict=True))
    return chi2(before) - chi2(after), chi2(distance)


def _stretches(case: Case, scored: Sequence[int]) -> dict[str, tuple[float, float]]:
    """First and last scored time [s] of each recording; no ends where all of it is scored."""
    stretches = {}
    for k, record in enumerate(case.simulations.records):
        windows = {i for i, w in enumerate(case.budget.windows) if w.record == k}
        rows = rows_of(case, scored, k, 0)
        if windows <= set(scored):
            stretches[record.name] = (-np.inf, np.inf)
        elif rows.size:
            time = record.signals[0].time
            stretches[record.name] = (float(time[rows[0]]), float(time[rows[-1]]))
    return stretches


def _refitted(misfit: Misfit, model: Fitted) -> Fitted:
    again = fit_to_the_end(misfit, model.hypothesis, model.parameters)
    assert again is not None, "it was simulated at these values before"
    return again


def _measured(misfit: Misfit, model: Fitted) -> Fitted:
    """Measure a model by other recordings, at values that no fit has adapted to them."""
    again = fit(misfit, model.hypothesis, model.parameters, parallel=True, iterations=1)
    assert again is not None, "it was simulated at these values before"
    return again


def _table(
    case: Case,
    scored: Sequence[int],
    base: Fitted,
    plain: Fitted,
    augmented: Fitted,
    unnamed: Sequence[Sequence[NDArray[np.float64]]] | None,
) -> dict[str, SignalFit]:
    names = [s.name for record in case.simulations.records for s in record.signals]
    table = {}
    for name in dict.fromkeys(names):
        nominal = _nrmse(case, scored, name, case.nominal)
        table[name] = SignalFit(
            nominal=nominal,
            parameters_only=_nrmse(case, scored, name, plain.simulated),
            augmented=(
                _nrmse(case, scored, name, augmented.simulated)
                if augmented.hypothesis.effects
                else float("nan")
            ),
            unnamed_spline=(
                float("nan")
                if unnamed is None
                else _nrmse(case, scored, name, base.simulated, unnamed)
            ),
            noise_floor=_floor(case, scored, name),
        )
    return table


def _nrmse(
    case: Case,
    scored: Sequence[int],
    name: str,
    simulated: Sequence[Simulated],
    added: Sequence[Sequence[NDArray[np.float64]]] | None = None,
) -> float:
    """RMS error over the range of the recorded signal, over all scored rows."""
    square, count, low, high = 0.0, 0, np.inf, -np.inf
    for k, record in enumerate(case.simulations.records):
        for i, signal in enumerate(record.signals):
            rows = rows_of(case, scored, k, i)
            if signal.name != name or not rows.size:
                continue
            residual = signal.values - simulated[k].signals[i]
            if added is not None:
                residual = residual - added[k][i]
            square += float(np.sum(residual[rows] ** 2))
            count += rows.size
            low = min(low, float(signal.values[rows].min()))
            high = max(high, float(signal.values[rows].max()))
    extent = high - low
    return float(np.sqrt(square / count) / extent) if count and extent > 0.0 else float("nan")


def _floor(case: Case, scored: Sequence[int], name: str) -> float:
    """NRMSE by noise alone: the sensor noise carried by the loop, and the signal's own noise."""
    squares, extents = [], []
    for k, record in enumerate(case.simulations.records):
        for i, signal in enumerate(record.signals):
            rows = rows_of(case, scored, k, i)
            if signal.name != name or not rows.size:
                continue
            through = case.budget.loop_noise[k]
            loop = float(np.mean([np.mean(c[i] ** 2) for c in through])) if through else 0.0
            squares.append(loop + case.budget.own_variances[k][i])
            extents.append(signal.values[rows])
    if not squares:
        return float("nan")
    values = np.concatenate(extents)
    extent = float(np.ptp(values))
    return float(np.sqrt(np.mean(squares)) / extent) if extent > 0.0 else float("nan")


def _removed(
    case: Case,
    scored: Sequence[int],
    plain: Fitted,
    augmented: Fitted,
    best: Fitted,
    least: float,
) -> float | None:
    """Share of the explainable whitened error that is gone; None where there is none.

    The noise floor has three upper bounds: the error budget, the residual of the whole library in
    all recordings, and that of the augmented twin here when fitted to all recordings.
    """
    whole = case.plain
    misfit = restricted(whole, scored)
    before, after, fitted_to_all = (
        chi2(misfit.residual(fitted.simulated)) for fitted in (plain, augmented, best)
    )
    size = sum(w.n_residuals for w in misfit.whiteners)
    noise = float(sum(case.budget.noise_squares[w] for w in scored))
    floor = min(noise, least * size, fitted_to_all)
    if before - floor < 2.0 * np.sqrt(2.0 * floor):
        return None
    return min(float((before - after) / (before - floor)), 1.0)


def _curves(case: Case, plain: Fitted, augmented: Fitted) -> tuple[Curve, ...]:
    units = {
        name: case.twin.binding.variables[entry.variable].variable.si_unit
        for name, entry in case.twin.file.outputs.items()
    }
    curves = []
    for k, record in enumerate(case.simulations.records):
        for i, signal in enumerate(record.signals):
            named = bool(augmented.hypothesis.effects)
            curves.append(
                Curve(
                    recording=record.name,
                    signal=signal.name,
                    unit=units.get(signal.name, ""),
                    time=signal.time,
                    recorded=signal.values,
                    nominal=case.nominal[k].signals[i],
                    parameters_only=plain.simulated[k].signals[i],
                    augmented=(
                        augmented.simulated[k].signals[i]
                        if named
                        else np.full(signal.values.size, np.nan)
                    ),
                )
            )
    return tuple(curves)
