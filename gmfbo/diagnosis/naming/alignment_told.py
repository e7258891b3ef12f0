"""Alignment of the columns as found, and laws that would explain a large misalignment as well."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.held_out_split import rows_of
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.result.estimated import Alignment
from gmfbo.diagnosis.runs.scored_record import ScoredSignal
from gmfbo.diagnosis.scoring.covariances import whiteners
from gmfbo.diagnosis.scoring.long_run_covariance import long_run_covariance
from gmfbo.diagnosis.scoring.nuisances import OFFSET, SHIFT_SHARE, Direction
from gmfbo.diagnosis.screening.testable_effects import candidates

Array = NDArray[np.float64]

FAR = 4.0
"""Standard deviations from which a column is off by more than its prior allows.

Of ten columns and kinds, chance takes one there once in 1,600 diagnoses (normal distribution).
"""

_KINDS = ("scale", "offset", "shift")

LAWS: Mapping[str, tuple[str, ...]] = {
    "scale": ("actuator_gain_loss", "sensor_scale"),
    "offset": ("constant_torque_offset", "sensor_offset"),
    "shift": ("transport_delay", "actuator_lag", "sensor_lag"),
}
"""Laws that look like each kind; which one does, the recordings tell."""


@dataclass(frozen=True, eq=False)
class _Seen:
    """One column over all recordings: scale - 1, offset [SI], shift [s], and their covariance."""

    sizes: Array
    covariance: Array

    @property
    def errors(self) -> Array:
        found: Array = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return found

    def believed(self, allowed: Array) -> Array:
        """The likeliest sizes under a normal prior with these standard deviations, shape (3,)."""
        free = np.flatnonzero(allowed > 0.0)
        units, found = allowed[free], np.zeros(3)
        beside_one = np.eye(free.size) + self.covariance[np.ix_(free, free)] / np.outer(
            units, units
        )
        found[free] = units * np.linalg.solve(beside_one, self.sizes[free] / units)
        return found


def alignments(case: Case, model: Fitted, untested: Collection[str] = ()) -> dict[str, Alignment]:
    """Scale, offset and lateness of each column against the final model, where it is scored.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    model : Fitted
        The final model.
    untested : collection of str
        Effects that are excluded, or that these recordings or this twin cannot show.
    """
    seen = {
        name: _seen(case, model, name)
        for name in dict.fromkeys(s.name for r in case.simulations.records for s in r.signals)
    }
    allowed = {name: _allowed(case, name) for name in seen}
    beyond = {name: _beyond_prior(case, one, allowed[name]) for name, one in seen.items()}
    told = {  # a prior that the recordings contradict is not believed
        name: one.sizes if beyond[name] else one.believed(allowed[name])
        for name, one in seen.items()
    }
    rival = _rival(case, model, {kind for kinds in beyond.values() for kind in kinds}, untested)
    return {
        name: Alignment(
            logged="new" if name in case.simulations.new_rows else "held",
            shift=float(shift),
            scale=float(1.0 + scale),
            offset=float(offset),
            rival=rival if any(rival in LAWS[kind] for kind in beyond[name]) else None,
            beyond_prior=beyond[name],
        )
        for name, (scale, offset, shift) in told.items()
    }


def _seen(case: Case, model: Fitted, name: str) -> _Seen:
    """Least squares over all recordings, with errors that allow for coloured residuals."""
    matrix, vector, spread = np.zeros((3, 3)), np.zeros(3), np.zeros((3, 3))
    pieces = list(_pieces(case, model, name))
    for columns, left in pieces:
        matrix += columns @ columns.T
        vector += columns @ left
    # A column that never moves has no scale and no lateness: the least change is taken.
    inverse = np.linalg.pinv(matrix, rcond=1e-12, hermitian=True)
    sizes = inverse @ vector
    for columns, left in pieces:
        spread += long_run_covariance(columns * (left - sizes @ columns))
    return _Seen(sizes, inverse @ spread @ inverse)


def _pieces(case: Case, model: Fitted, name: str) -> list[tuple[Array, Array]]:
    """Directions of one column, shape (3, rows), and its residual, in each recording."""
    found = []
    for k, (record, run) in enumerate(zip(case.simulations.records, model.simulated, strict=True)):
        for i, (signal, values) in enumerate(zip(record.signals, run.signals, strict=True)):
            if signal.name == name:
                rows = rows_of(case, range(len(case.budget.windows)), k, i)
                if rows.size:
                    directions = _directions(signal, values)[:, rows]
                    found.append((directions, (signal.values - values)[rows]))
    return found


def _directions(signal: ScoredSignal, values: Array) -> Array:
    """Change of a column per unit of scale, offset and lateness."""
    rate = np.gradient(values, signal.spacing)
    return np.stack([values, np.ones(values.size), -rate])


def _beyond_prior(case: Case, seen: _Seen, allowed: Array) -> dict[str, float]:
    """Kinds of which a column has more than its prior allows, in standard deviations."""
    if case.simulations.tracking is not None:
        return {}  # a controller holds the twin on the recorded position, whatever its column is
    deviations = np.abs(seen.sizes) / np.maximum(np.hypot(allowed, seen.errors), 1e-300)
    return {
        kind: float(deviation)
        for kind, deviation in zip(_KINDS, deviations, strict=True)
        if deviation > FAR
    }


def _allowed(case: Case, name: str) -> Array:
    """Standard deviations of a column's scale - 1, offset [SI] and shift [s] by its prior."""
    prior = case.rig.alignments[name]
    signals = [s for r in case.simulations.records for s in r.signals if s.name == name]
    extent = max(float(np.ptp(s.values)) for s in signals)
    spacing = max(s.spacing for s in signals)
    # An encoder has no free offset in the budget, but none is exact either.
    offset = (prior.offset or OFFSET) * extent
    return np.array([prior.scale, offset, prior.shift or SHIFT_SHARE * spacing])


def _rival(
    case: Case, model: Fitted, kinds: Collection[str], untested: Collection[str]
) -> str | None:
    """Law that explains the recordings as well as misaligned columns do, if there is one.

    All are fitted with every column free and no law, or with one law and no column. Free
    parameters count by Akaike (1974), as among an effect's rivals.
    """
    named = {candidate.effect for candidate in model.hypothesis.effects}
    looking_alike = {law for kind in kinds for law in LAWS[kind]} - named - set(untested)
    if not looking_alike:
        return None
    free = [_free_columns(case, model, k) for k in range(len(model.simulated))]
    bound: list[list[Direction]] = [[] for _ in free]
    by_columns = _left(case, model, free, model.hypothesis)
    if by_columns is None:
        return None
    most = by_columns + 2.0 * sum(len(free[w.record]) for w in case.budget.windows)
    left: dict[str, float] = {}
    for candidate in candidates(looking_alike, case.setting.excitation):
        effects = (*model.hypothesis.effects, candidate)
        by_law = _left(case, model, bound, replace(model.hypothesis, effects=effects))
        if by_law is not None and by_law + 2.0 * len(candidate.parameters) <= most:
            left[candidate.effect] = min(by_law, left.get(candidate.effect, np.inf))
    return min(left, key=lambda law: left[law], default=None)


def _left(
    case: Case, model: Fitted, free: Sequence[list[Direction]], hypothesis: Hypothesis
) -> float | None:
    """Misfit of a hypothesis where these directions of each recording are free, and no others."""
    made = whiteners(case.budget.windows, case.budget.covariances, free)
    found = fit(Misfit(case.simulations, made), hypothesis, model.parameters, parallel=True)
    return None if found is None else found.chi2


def _free_columns(case: Case, model: Fitted, record: int) -> list[Direction]:
    """Misalignments of one recording's columns, each as large as its signal's range."""
    signals = case.simulations.records[record].signals
    runs = model.simulated[record].signals
    free: list[Direction] = []
    for place, (signal, values) in enumerate(zip(signals, runs, strict=True)):
        for direction in _directions(signal, values):
            size = float(np.sqrt(np.mean(direction**2)))
            if size > 0.0:
                column = float(np.ptp(signal.values)) / size * direction
                free.append(
                    tuple(column if i == place else 0.0 * run for i, run in enumerate(runs))
                )
    return free
