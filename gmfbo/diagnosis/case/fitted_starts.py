"""Fit the starts of an axis to its recordings, where its twin file has `[initial] NAME = "fit"`.

What a start adds to a linear axis is a free response, so that a step of Gauss and Newton finds it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.held_out_split import rows_of
from gmfbo.diagnosis.fitting.fit import Fitted, fit_to_the_end
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.runs.fitted_start import FittedStart
from gmfbo.diagnosis.runs.scored_record import ScoredSignal
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.runs.start_changes import changes_by, own_points, start_changes
from gmfbo.diagnosis.scoring.noise_levels import SECOND_DIFFERENCE, rounding_of
from gmfbo.errors import RecordingError
from gmfbo.plain_words import quantity
from gmfbo.sources.twin.twin import FmuTwin

Array = NDArray[np.float64]

_COUNTS = 5.0  # of which rounding hides a twentieth
_BEGINNING = 0.1  # of a recording, within which they are waited for
_FIRST_ROWS = 8  # the slope of a noisy position is known from so many to 15 % of a row's noise
_ROUNDS, _OWN_ROUNDS = 10, 3
_SETTLED = 0.1  # of a whitened square
_SHOWN, _LEAST_STEP, _LARGEST_STEP = 20.0, 1e-5, 1e-2  # of a row's noise; of a signal's range
_PROBE = 1e-3  # of a start, or its unit: only its effect's size is read
_LEAST_EFFECT = 1e-9  # of a signal's range, per unit: the axis has nothing of this start


def begun_at_first_rows(
    simulations: Simulations, twin: FmuTwin, runs: list[Simulated]
) -> list[Simulated]:
    """Let the twin start where the first rows are, where its file wants starts fitted.

    There neither parameters nor forces have moved the axis yet.

    Parameters
    ----------
    simulations : Simulations
        Of the recordings; is told the starts.
    twin : FmuTwin
        With its twin file.
    runs : list of Simulated
        The twin as it is.

    Returns
    -------
    list of Simulated
        The twin from there; the same where no start is fitted.

    Raises
    ------
    RecordingError
        A start moves no recorded signal.
    """
    if not twin.file.fitted_starts:
        return runs
    probed = tuple(_unmeasured(twin, name, len(runs)) for name in twin.file.fitted_starts)
    columns = changes_by(simulations, probed, Point(), runs)
    found = []
    for start, own in zip(probed, columns, strict=True):
        effect = _largest_effect(simulations, own)
        if effect < _LEAST_EFFECT:
            raise RecordingError(
                f'[initial] {start.name} = "fit": expected a start that moves a recorded signal; '
                f"{start.name} moves none; give a number in its place"
            )
        spread = start.spread / effect
        found.append(replace(start, spread=spread, step=spread * _step_share(simulations)))
    _refuse_blank_beginnings(simulations)

    def first_rows(record: int, signal: int) -> NDArray[np.int64]:
        return np.arange(_told_within(simulations.records[record].signals[signal]))

    simulations.starts = _led(simulations, found, Point(), runs, first_rows)
    return simulations.run([Point()])[0]


def _refuse_blank_beginnings(simulations: Simulations) -> None:
    """A start cannot be told by rows that are blank: what is known begins elsewhere."""
    for record in simulations.records:
        first = float(record.plan.grid[0])
        late = min(signal.time[0] - _FIRST_ROWS * signal.spacing for signal in record.signals)
        if late > first:
            raise RecordingError(
                f'{record.name}: [initial] NAME = "fit" needs a signal from the first row on, its '
                f"first {late - first:.2g} s are blank; cut them"
            )


def at_own_starts(case: Case, point: Point, told_by: Collection[int]) -> Point:
    """A point with the starts that suit it: another model begins elsewhere.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    point : Point
        Of a model.
    told_by : collection of int
        Windows that tell the starts of their recordings; of others, all rows do.
    """
    return _beginning_at(point, _own_starts(case, point, told_by))


def _beginning_at(point: Point, starts: Sequence[FittedStart]) -> Point:
    for start in starts:
        point = replace(point, own=own_points(point, start.name, start.values))
    return point


def _own_starts(case: Case, point: Point, told_by: Collection[int]) -> tuple[FittedStart, ...]:
    simulations, starts = case.simulations, case.simulations.starts
    if not starts:
        return ()

    def rows(k: int, i: int) -> NDArray[np.int64]:
        own = rows_of(case, sorted(told_by), k, i)
        return own if own.size else np.arange(simulations.records[k].signals[i].values.size)

    for _ in range(_OWN_ROUNDS):
        there = _beginning_at(point, starts)
        starts = _led(simulations, starts, there, simulations.run([there])[0], rows)
    return starts


def _led(
    simulations: Simulations,
    starts: Sequence[FittedStart],
    point: Point,
    runs: Sequence[Simulated],
    rows: Callable[[int, int], NDArray[np.int64]],
) -> tuple[FittedStart, ...]:
    """Starts after a step to where a point leaves least of some rows of each signal."""
    columns = changes_by(simulations, starts, point, runs)
    steps = []
    for k, (record, run) in enumerate(zip(simulations.records, runs, strict=True)):
        left, moved = [], []
        for i, signal in enumerate(record.signals):
            noise, own = _noise(signal), rows(k, i)
            left.append((signal.values - run.signals[i])[own] / noise)
            moved.append([column[k][i][own] / noise for column in columns])
        steps.append(_step(np.concatenate(left), np.concatenate(moved, axis=1)))
    return _after(starts, steps)


def _told_within(signal: ScoredSignal) -> int:
    """Number of the first rows that tell a slope: coarse counts stay the same over a few."""
    most = int(_BEGINNING * signal.values.size)
    moved = np.abs(signal.values[:most] - signal.values[0]) >= _COUNTS * signal.resolution
    return max(_FIRST_ROWS, int(np.argmax(moved)) + 1 if moved.any() else most)


def fitted_with_starts(
    misfit: Misfit, hypothesis: Hypothesis, parameters: Mapping[str, float]
) -> Fitted:
    """Fit the twin's parameters, and the starts, in turn.

    What the starts may make of the signals is left out while parameters are fitted (variable
    projection; Golub and Pereyra 1973): a wrong start then bends no parameter.

    Parameters
    ----------
    misfit : Misfit
        Whitens by noise alone; its simulators are told the starts.
    hypothesis : Hypothesis
        The twin.
    parameters : mapping of str to float
        [FMU's unit] Where the fit begins.
    """
    base = _beside_starts(misfit, hypothesis, parameters)
    if not hypothesis.names:
        return base  # over a whole recording, a twin that swings otherwise has no start of its own
    for _ in range(_ROUNDS):
        if not settle_starts(misfit, base):
            break
        base = _beside_starts(misfit, hypothesis, base.parameters)
    return base


def _beside_starts(
    misfit: Misfit, hypothesis: Hypothesis, parameters: Mapping[str, float]
) -> Fitted:
    simulations = misfit.simulations
    point = hypothesis.point(hypothesis.start(parameters))
    changed = start_changes(simulations, point, simulations.run([point])[0])
    left_out = misfit.with_whiteners(
        [w.without([own[w.window.record] for own in changed]) for w in misfit.whiteners]
    )
    base = fit_to_the_end(left_out, hypothesis, parameters)
    assert base is not None, "the twin was simulated at these values a moment ago"
    return base


def settle_starts(misfit: Misfit, base: Fitted) -> bool:
    """Move the starts to where a fit leaves least of each recording; False where they are there.

    Parameters
    ----------
    misfit : Misfit
        Whitens by noise alone; its simulators are told the starts.
    base : Fitted
        The twin with its parameters fitted.
    """
    simulations, runs = misfit.simulations, base.simulated
    if not simulations.starts:
        return False
    changed = start_changes(simulations, base.hypothesis.point(base.x), runs)
    columns = [misfit.whitened(own) for own in changed]
    residual = misfit.residual(runs)
    steps, promised = [], 0.0
    for k in range(len(runs)):
        blocks = [b for b, w in enumerate(misfit.whiteners) if w.window.record == k]
        left = np.concatenate([np.empty(0), *(residual[b] for b in blocks)])
        moved = np.array([np.concatenate([np.empty(0), *(c[b] for b in blocks)]) for c in columns])
        step = _step(left, moved)
        promised = max(promised, float(left @ left - np.sum((left - step @ moved) ** 2)))
        steps.append(step)
    if promised < _SETTLED:
        return False
    simulations.starts = _after(simulations.starts, steps)
    return True


def _step(left: Array, moved: Array) -> Array:
    """Starts in units of their spreads that explain most of a residual, under their priors."""
    normal = moved @ moved.T + np.eye(len(moved))
    return np.asarray(np.linalg.solve(normal, moved @ left), dtype=np.float64)


def _after(starts: Sequence[FittedStart], steps: Sequence[Array]) -> tuple[FittedStart, ...]:
    return tuple(
        start.moved([start.spread * float(step[i]) for step in steps])
        for i, start in enumerate(starts)
    )


def _unmeasured(twin: FmuTwin, name: str, recordings: int) -> FittedStart:
    """A start at the twin's value, with a spread of its own size."""
    variable, value = twin.binding.variables[name].variable, twin.nominal(name)
    low = -np.inf if variable.minimum is None else variable.minimum
    high = np.inf if variable.maximum is None else variable.maximum
    size = abs(value) or 1.0
    return FittedStart(name, (value,) * recordings, size, _PROBE * size, low, high)


def _step_share(simulations: Simulations) -> float:
    """Of the start that moves a signal by its range: a step that shows beside the least noise.

    A larger one would break an axis loose of its friction.
    """
    shares = [
        _noise(signal) / float(np.ptp(signal.values))
        for record in simulations.records
        for signal in record.signals
        if np.ptp(signal.values) > 0.0
    ]
    return float(np.clip(_SHOWN * min(shares, default=1.0), _LEAST_STEP, _LARGEST_STEP))


def _largest_effect(simulations: Simulations, columns: Sequence[Sequence[Array]]) -> float:
    """Largest change of a signal, of its range over all recordings."""
    ranges: dict[str, float] = {}
    for record in simulations.records:
        for signal in record.signals:
            extent = float(np.ptp(signal.values))
            ranges[signal.name] = max(ranges.get(signal.name, 0.0), extent)
    return max(
        (
            float(np.abs(column).max()) / ranges[signal.name]
            for record, own in zip(simulations.records, columns, strict=True)
            for signal, column in zip(record.signals, own, strict=True)
            if ranges[signal.name] > 0.0
        ),
        default=0.0,
    )


def _noise(signal: ScoredSignal) -> float:
    """Deviation of a row's noise, by its second differences; a floor where it has none.

    Of a coarse count most second differences are none: it has its rounding.
    """
    deviation = float(np.median(np.abs(np.diff(signal.values, 2)))) / SECOND_DIFFERENCE
    least = max(rounding_of(signal), 1e-6 * float(np.ptp(signal.values)), 1e-300)
    return float(max(deviation, least))


def told_starts(case: Case, model: Fitted | None = None) -> list[str]:
    """A note for each fitted start: its values.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    model : Fitted, optional
        That starts there; without it, the case's own starts are told.
    """
    variables, records = case.twin.binding.variables, case.simulations.records
    starts = case.simulations.starts
    if model is not None:
        windows = range(len(case.budget.windows))
        starts = _own_starts(case, model.hypothesis.point(model.x), windows)
    found = []
    for start in starts:
        unit = variables[start.name].variable.si_unit or ""
        told = ", ".join(
            f"{quantity(value, unit)} ({record.name}{', the bound of the FMU' if ends else ''})"
            for value, record, ends in zip(start.values, records, start.at_bound, strict=True)
        )
        found.append(f"[initial] {start.name} was fitted to each recording: {told}")
    return found
