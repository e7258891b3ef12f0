"""Compare the predictions of a diagnosis with a recording that was made afterwards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.open_case import open_case
from gmfbo.diagnosis.checking.two_readings import straight
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.experiment.explained_twin import check_known, points_of, saved_predictions
from gmfbo.diagnosis.experiment.menu_runs import playing
from gmfbo.diagnosis.experiment.observed import Confirmation, Prediction
from gmfbo.diagnosis.result.predictions import Explanation, Predictions
from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.scoring.noise_levels import (
    loop_covariance,
    tolerance_covariance,
    white_covariance,
)
from gmfbo.diagnosis.scoring.nuisances import Direction, actuator_directions, record_directions
from gmfbo.diagnosis.scoring.whitening import Spectrum, Whitener, Window
from gmfbo.errors import SimulationError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin

_ALIGNED = 1.0 / 3.0  # of a recording, within which nuisances are fitted; the rest is scored


def confirm_with(
    twin: FmuTwin,
    diagnosis: Diagnosis,
    recording: Recording,
    *,
    seed: int = 0,
    jobs: int | None = None,
) -> Confirmation:
    """Compare each explanation's prediction with a recording; no physics is refitted.

    Nuisances (clock, scales, zeros, the actuator's lag and gain) are fitted for each explanation
    to stretches within the first third. The rest is scored, with the remaining uncertainty of
    these nuisances.

    Parameters
    ----------
    twin : FmuTwin
        The twin that was diagnosed.
    diagnosis : Diagnosis
        With the values of its explanations.
    recording : Recording
        Of the same axis, made afterwards.
    seed : int
        Of the noise that is sent through the loop.
    jobs : int, optional
        Simulations at a time; one a processor unless given.

    Raises
    ------
    InputError
        The diagnosis is of another twin or of an older version.
    RecordingError
        There is too little to compare.
    SimulationError
        The twin cannot follow the recording under any explanation.
    """
    told = saved_predictions(diagnosis)
    for explanation in told.explanations:
        check_known(explanation, twin)
    case = _opened(twin, told, recording, seed, jobs)
    try:
        return _Judge(case, twin, told).confirmation(recording.name or "the recording")
    finally:
        case.simulations.close()


def _opened(
    twin: FmuTwin, told: Predictions, recording: Recording, seed: int, jobs: int | None
) -> Case:
    """A case in which nothing is uncertain, so that nothing is refitted."""
    known = [name for name in told.straight if name in twin.file.inputs]
    fixed = straight(twin, known).with_uncertain({})
    rows = None if recording.written_by else frozenset(told.new_rows)
    return open_case(fixed, [recording], seed=seed, jobs=jobs, new_rows=rows)


class _Judge:
    """Scores explanations on one recording by one error budget."""

    def __init__(self, case: Case, twin: FmuTwin, told: Predictions) -> None:
        self.case, self.twin, self.told = case, twin, told
        self.record: Record = case.simulations.records[0]
        self.first, self.rest = _parts(case)

    def confirmation(self, name: str) -> Confirmation:
        case = self.case
        points = points_of(self.told.explanations, case.setting, self.twin)
        # A prediction cannot know the noise of the recording: the budget holds all of it.
        with playing(case, (self.record,)):
            return self._judged(name, points)

    def _judged(self, name: str, points: Mapping[str, Point]) -> Confirmation:
        case = self.case
        runs = case.simulations.run(list(points.values()))
        found = [
            (explanation, point, run)
            for explanation, point, run in zip(
                self.told.explanations, points.values(), runs, strict=True
            )
            if run[0].finite
        ]
        if not found:
            raise SimulationError(
                f"{case.twin.name}: the twin cannot follow {name} under any explanation: "
                f"{runs[0][0].response.outcome.message}"
            )
        scored = [self._scored(*one) for one in found]
        times = [_times(self.record, whitener.window) for whitener in self.rest]
        start, end = min(a for a, _ in times), max(b for _, b in times)
        nearest = tuple(sorted(scored, key=lambda p: p.chi2))
        return Confirmation(name, (start, end), nearest, self.told.threshold)

    def _scored(
        self,
        explanation: Explanation,
        point: Point,
        run: list[Simulated],
    ) -> Prediction:
        columns = [
            signal.values - values
            for signal, values in zip(self.record.signals, run[0].signals, strict=True)
        ]
        directions = self._directions(point, run)
        chi2 = _predictive(self.first, self.rest, columns, directions)
        count = sum(whitener.n_residuals for whitener in self.rest)
        nrmse = {
            signal.name: _nrmse(signal.values, columns[i], [w.window.rows[i] for w in self.rest])
            for i, signal in enumerate(self.record.signals)
        }
        return Prediction(explanation.name, chi2, chi2 / count, explanation.misfit, nrmse)

    def _directions(self, point: Point, run: list[Simulated]) -> list[Direction]:
        case = self.case
        excitation = case.setting.excitation
        ratio = excitation.torque / excitation.command
        own = record_directions(self.record, run[0], case.rig.alignments)
        return own + actuator_directions(case.simulations, point, run, 0, ratio)


def _predictive(
    first: Sequence[Whitener],
    rest: Sequence[Whitener],
    columns: Sequence[NDArray[np.float64]],
    directions: Sequence[Direction],
) -> float:
    """chi2 of the rest given the first part, plus that of the nuisances fitted to it.

    The first part gives each nuisance a value and a covariance P; the rest is scored as
    r' (I + N' P N)^-1 r, by the identity of Woodbury (1950). Otherwise a scale that one slow
    pass could not tell from a zero would count as a wrong prediction.
    """
    prior = np.eye(len(directions))
    seen, target = _stacked(first, directions), _stacked(first, [columns])[0]
    precision = prior + seen @ seen.T
    sizes = np.linalg.solve(precision, seen @ target)
    later = _stacked(rest, directions)
    left = _stacked(rest, [columns])[0] - sizes @ later
    open_part = later @ left
    explained = open_part @ np.linalg.solve(precision + later @ later.T, open_part)
    return float(left @ left - explained + sizes @ sizes)


def _stacked(
    whiteners: Sequence[Whitener], columns: Sequence[Sequence[NDArray[np.float64]]]
) -> NDArray[np.float64]:
    """Whitened columns over some windows, shape (n_columns, n_residuals)."""
    if not whiteners:
        return np.zeros((len(columns), 0))
    return np.array([np.concatenate([w.whiten(column) for w in whiteners]) for column in columns])


def _parts(case: Case) -> tuple[list[Whitener], list[Whitener]]:
    """Windows within the first third, used to align, and all later windows."""
    record, budget = case.simulations.records[0], case.budget
    times = [_times(record, window) for window in budget.windows]
    start, end = min(a for a, _ in times), max(b for _, b in times)
    border = start + _ALIGNED * (end - start)
    first: list[Whitener] = []
    rest: list[Whitener] = []
    for window, (_, last) in zip(budget.windows, times, strict=True):
        (first if last <= border else rest).append(Whitener(window, _covariance(case, window)))
    return first, rest


def _covariance(case: Case, window: Window) -> Spectrum:
    """S(f) of a window: own noise, noise through the loop, and tolerance."""
    budget, record = case.budget, case.simulations.records[0]
    own = white_covariance(window, budget.own_variances[0])
    through = loop_covariance(window, budget.loop_noise[0])
    return own + through + tolerance_covariance(window, record, case.rig.positions)


def _times(record: Record, window: Window) -> tuple[float, float]:
    """[s] First and last time of a window."""
    pairs = list(zip(record.signals, window.rows, strict=True))
    first = min(float(signal.time[rows.start]) for signal, rows in pairs)
    last = max(float(signal.time[rows.stop - 1]) for signal, rows in pairs)
    return first, last


def _nrmse(values: NDArray[np.float64], left: NDArray[np.float64], rows: Sequence[slice]) -> float:
    """RMS error over the range of the recorded signal, both on these rows."""
    error = np.concatenate([left[r] for r in rows])
    extent = float(np.ptp(np.concatenate([values[r] for r in rows])))
    return float(np.sqrt(np.mean(error**2))) / (extent or 1.0)
