"""Validate the augmented twin on held-out recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.held_out_split import Split, restricted, rows_of
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted as Row
from gmfbo.diagnosis.comparison.held_out_fit import (
    Part,
    foretelling,
    gains_on,
    ledger_on,
    part_of,
    quiet,
    seen_on,
    squares_on,
)
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.numbers import SAME
from gmfbo.diagnosis.comparison.row_fits import RowFits
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.naming.decided_by_score import measured
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.result.curve import Curve
from gmfbo.diagnosis.result.held_out_errors import Fit, SignalFit
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.validating.explained_share import Squares
from gmfbo.diagnosis.validating.free_run import free_runs
from gmfbo.diagnosis.validating.noise_floors import noise_floors

_STANDARD_ERRORS = 2.0  # by which held-out stretches have to speak against names
_ONE_NAT = 1.0  # of log density: less says nothing, however even
_REFITTED = 8  # steps of a fit without one of the names


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
        Of the windows that were fitted.
    part : Part
        The augmented twin in the comparison, on the same windows.
    contradicts_names : bool
        Whether held-out recordings contradict the named physics.
    gains_nothing : bool
        Whether they are met no better with it: as much is left beyond noise as without, and they do
        not contradict the twin without it; or all errors grow, and the log density does not.
    squares : Squares
        What the held-out stretches leave.
    """

    fit: Fit
    curves: tuple[Curve, ...]
    scored: Mapping[str, tuple[float, float]]
    parameters_only: Fitted
    augmented: Fitted
    misfit: Misfit
    part: Part
    contradicts_names: bool
    gains_nothing: bool
    squares: Squares


def validate(
    case: Case,
    decision: Decision,
    split: Split,
    unnamed: Sequence[Simulated] | None,
) -> Validated:
    """Refit on the fitted windows alone, and score on the others.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        What was accepted.
    split : Split
        Which windows are fitted.
    unnamed : sequence of Simulated, optional
        The recordings by a model without a name.
    """
    chosen = split.fitted or tuple(range(len(case.budget.windows)))
    search, ledger = decision.compared.search, decision.compared.ledger
    # Beside what it lacks, the twin alone is fitted under the inadequacy that it leaves.
    opened = replace(ledger, levels=ledger.opened) if decision.row.elements else ledger
    before = part_of(case, search, opened, decision.base, chosen)
    after = before
    if decision.row.elements:
        after = part_of(case, search, ledger, decision.row, chosen).with_other_modes()
    scored = split.held_out or chosen
    left = decision.compared.scored.size_beside(decision.row.elements)
    told = [quiet(case, part.fitted, chosen) for part in (before, after)]
    about = (decision.base, decision.row)
    there = foretelling(search, ledger, decision.row)
    fine = (quiet(case, part.fitted, chosen, search.problem) for part in (before, after))
    seen = [seen_on(case, search, there, row, scored, about, left) for row in fine]
    without = {}
    for name, row in _rows_without(decision).items():
        part = part_of(case, search, ledger, row, chosen)
        lost = quiet(case, part.fitted, chosen, search.problem)
        without[name] = seen_on(case, search, there, lost, scored, about)
    misfit = restricted(case.misfit, chosen)
    plain = measured(misfit, told[0])
    augmented = plain if after is before else measured(misfit, told[1])
    models = _Told(case, misfit, scored, plain, augmented, split, unnamed)
    return _scored(models, after, _Seen(decision, there, seen[0], seen[1], without))


def validate_unseen(case: Case, unseen: Case, decision: Decision) -> Validated:
    """Score models of some recordings on others that had no part in any fit.

    Parameters
    ----------
    case : Case
        Twin and the recordings that were fitted.
    unseen : Case
        The same twin and the other recordings.
    decision : Decision
        What was accepted.
    """
    split = Split(
        tuple(range(len(case.budget.windows))),
        tuple(range(len(unseen.budget.windows))),
        tuple(record.name for record in case.simulations.records),
        tuple(record.name for record in unseen.simulations.records),
    )
    # Found while the effects were decided, after these recordings had been opened.
    unseen.simulations.begins_at_rest = case.simulations.begins_at_rest
    search, ledger = decision.compared.search, decision.compared.ledger
    whole = part_of(case, search, ledger, decision.row, split.fitted).with_other_modes()
    there_ledger = ledger_on(unseen, search, ledger, whole.fitted)
    there, left = [], decision.compared.scored.size_beside(decision.row.elements)
    for row in (decision.base, whole.fitted):
        run = quiet(unseen, row, problem=search.problem)
        there.append(seen_on(unseen, search, there_ledger, run, split.held_out, (), left))
    models = [quiet(unseen, row) for row in (decision.base, whole.fitted)]
    plain, augmented = (measured(unseen.misfit, model) for model in models)
    told = _Told(unseen, case.misfit, split.held_out, plain, augmented, split, None)
    without = {}
    for name, row in _rows_without(decision).items():
        lost = quiet(unseen, row, problem=search.problem)
        without[name] = seen_on(unseen, search, there_ledger, lost, split.held_out, ())
    seen = _Seen(decision, there_ledger, there[0], there[1], without)
    found = _scored(told, whole, seen)
    return replace(
        found,
        parameters_only=measured(case.misfit, decision.base),
        augmented=measured(case.misfit, whole.fitted),
    )


def _rows_without(decision: Decision) -> dict[str, Row]:
    """Rows that lack one of several named effects; of one alone, the refitted twin does."""
    names = [found.winner.name for found in decision.rounds]
    if len(names) < 2 and len(decision.row.elements) < 2:
        return {}
    rows = {name: row_without(decision, name) for name in names}
    return {name: row for name, row in rows.items() if row is not None}


def row_without(decision: Decision, name: str) -> Row | None:
    """The row that lacks a named effect, fitted if the comparison has not; None where none fits.

    Parameters
    ----------
    decision : Decision
        What was accepted.
    name : str
        The effect.
    """
    search, ledger = decision.compared.search, decision.compared.ledger
    known = ledger.rows.get(decision.row.elements - {name})
    return known or RowFits(search.problem, ledger.noise_of).without(
        ledger.whitening, decision.row, name, _REFITTED
    )


@dataclass(frozen=True, eq=False)
class _Seen:
    """Models on the stretches that are scored."""

    decision: Decision
    ledger: Ledger
    before: Part
    after: Part
    without: Mapping[str, Part]

    def squares(self) -> Squares:
        decision = self.decision
        parts = [self.before, *self.without.values(), self.after]
        noise, before, *others, after = squares_on(
            decision.compared.search, self.ledger, parts, (decision.base, decision.row)
        )
        lost = dict(zip(self.without, others, strict=True))
        if not lost:
            lost = {found.winner.name: before for found in self.decision.rounds}
        return Squares(noise, before, after, lost)

    def nominal(self, runs: list[Simulated]) -> Part:
        """The twin as it came, with the logging that the refitted one has."""
        problem, fitted = self.before.problem, self.before.fitted
        runs = problem.as_it_came(runs)
        values = problem.values(runs)
        residual = problem.residual(values, fitted.nuisances)
        there = replace(fitted, runs=runs, values=values, residual=residual, columns=[])
        return replace(self.before, fitted=there)


@dataclass(frozen=True, eq=False)
class _Told:
    """Models, and the recordings on which they are scored."""

    case: Case
    misfit: Misfit
    scored: Sequence[int]
    plain: Fitted
    augmented: Fitted
    split: Split
    unnamed: Sequence[Simulated] | None


def _scored(told: _Told, part: Part, seen: _Seen) -> Validated:
    case, augmented = told.case, told.augmented
    shown = augmented if seen.decision.row.elements else None
    floors, gains = noise_floors(seen.after, seen.ledger), gains_on(seen.before, seen.after)
    signals = _table(case, told.scored, told.plain, shown, told.unnamed, floors)
    distance, nominal = _distance(seen.before, seen.after), seen.nominal(case.nominal)
    squares = seen.squares()
    removed = squares.removed if distance > SAME else None
    preferred, apart = gains_on(nominal, seen.after), _distance(nominal, seen.after)
    is_worse = apart > SAME and preferred.sum() < 0.0 and all(s.is_worse for s in signals.values())
    only_worse = gains.sum() <= 0.0 and all(s.is_worse_with_physics for s in signals.values())
    is_no_better = squares.gain_nothing and not contradicts_names(-gains, distance)
    table = Fit(
        told.split.names_fitted,
        told.split.names_held_out,
        signals,
        removed,
        None if shown is None else float(gains.sum()),
        None if shown is None else _error_of(gains),
        contradicts_names(preferred, apart) or bool(is_worse),
    )
    return Validated(
        table,
        _curves(case, told.plain, shown),
        _stretches(case, told.scored),
        told.plain,
        augmented,
        told.misfit,
        part,
        contradicts_names(gains, distance),
        bool(only_worse) or (distance > SAME and is_no_better),
        squares,
    )


def contradicts_names(gains: NDArray[np.float64], distance: float) -> bool:
    """Whether held-out stretches speak against a model that differs from the refitted twin there.

    Parameters
    ----------
    gains : ndarray, shape (n_stretches,)
        [nats] Log density of the model, less that of the refitted twin.
    distance : float
        Squared whitened distance of the two.
    """
    least = -max(_STANDARD_ERRORS * _error_of(gains), _ONE_NAT)
    return bool(distance > SAME and gains.sum() < least)


def _error_of(gains: NDArray[np.float64]) -> float:
    """[nats] Standard error of the sum over stretches."""
    return float(np.std(gains) * np.sqrt(gains.size))


def _distance(before: Part, after: Part) -> float:
    """Squared whitened distance of two models."""
    change = [a - b for a, b in zip(after.fitted.residual, before.fitted.residual, strict=True)]
    return before.whitening.square(change)


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


def _table(
    case: Case,
    scored: Sequence[int],
    plain: Fitted,
    augmented: Fitted | None,
    unnamed: Sequence[Simulated] | None,
    floors: Mapping[str, float],
) -> dict[str, SignalFit]:
    names = [s.name for record in case.simulations.records for s in record.signals]
    free, table = free_runs(case, scored, plain, augmented), {}
    for name in dict.fromkeys(names):
        nominal = _nrmse(case, scored, name, case.nominal)
        table[name] = SignalFit(
            nominal=nominal,
            parameters_only=_nrmse(case, scored, name, plain.simulated),
            augmented=(
                float("nan")
                if augmented is None
                else _nrmse(case, scored, name, augmented.simulated)
            ),
            unnamed_spline=(
                float("nan") if unnamed is None else _nrmse(case, scored, name, unnamed)
            ),
            noise_floor=_of_range(case, scored, name, floors.get(name, np.nan)),
            free_run=free.get(name),
        )
    return table


def _nrmse(
    case: Case,
    scored: Sequence[int],
    name: str,
    simulated: Sequence[Simulated],
) -> float:
    """RMS error over the range of the recorded signal, over all scored rows."""
    square, count = 0.0, 0
    for k, record in enumerate(case.simulations.records):
        for i, signal in enumerate(record.signals):
            rows = rows_of(case, scored, k, i)
            if signal.name == name:
                square += float(np.sum((signal.values - simulated[k].signals[i])[rows] ** 2))
                count += rows.size
    return _of_range(case, scored, name, float(np.sqrt(square / count)) if count else np.nan)


def _of_range(case: Case, scored: Sequence[int], name: str, error: float) -> float:
    """An error [SI] over the range of the recorded signal, over all scored rows."""
    values = np.concatenate(
        [
            signal.values[rows_of(case, scored, k, i)]
            for k, record in enumerate(case.simulations.records)
            for i, signal in enumerate(record.signals)
            if signal.name == name
        ]
    )
    extent = float(np.ptp(values)) if values.size else 0.0
    return error / extent if extent > 0.0 else float("nan")


def _curves(case: Case, plain: Fitted, augmented: Fitted | None) -> tuple[Curve, ...]:
    units = {
        name: case.twin.binding.variables[entry.variable].variable.si_unit
        for name, entry in case.twin.file.outputs.items()
    }
    curves = []
    for k, record in enumerate(case.simulations.records):
        for i, signal in enumerate(record.signals):
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
                        np.full(signal.values.size, np.nan)
                        if augmented is None
                        else augmented.simulated[k].signals[i]
                    ),
                )
            )
    return tuple(curves)
