"""Predictions of a diagnosis held against a recording that was made afterwards."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case import Case
from gmfbo.diagnosis.confirmation import Confirmation, Prediction
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.explained_twin import check_known, points_of
from gmfbo.diagnosis.nuisances import Direction, actuator_directions, record_directions
from gmfbo.diagnosis.opening import open_case
from gmfbo.diagnosis.predictions import Explanation, Predictions
from gmfbo.diagnosis.records import Record
from gmfbo.diagnosis.simulations import Point, Simulated
from gmfbo.diagnosis.whitening import Whitener, Window
from gmfbo.errors import InputError, SimulationError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin import FmuTwin

_ALIGNED = 1.0 / 3.0  # of a recording, within which nuisances are fitted; the rest is scored


def confirm_with(
    twin: FmuTwin,
    diagnosis: Diagnosis,
    recording: Recording,
    *,
    seed: int = 0,
    jobs: int | None = None,
) -> Confirmation:
    """Hold what each explanation predicts against a recording; no physics is refitted.

    Clock, scales, zeros and the actuator's small lag and gain, which every rig is off by, are
    fitted for each explanation to stretches within the first third; the rest is scored.

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
    told = diagnosis.predictions
    if told is None:
        raise InputError(
            "expected a diagnosis that holds 'predictions', which this older one does not; "
            "diagnose again"
        )
    for explanation in told.explanations:
        check_known(explanation, twin)
    case = _opened(twin, told, recording, seed, jobs)
    try:
        return _Judge(case, told).confirmation(recording.name or "the recording")
    finally:
        case.simulations.close()


def _opened(
    twin: FmuTwin, told: Predictions, recording: Recording, seed: int, jobs: int | None
) -> Case:
    """A case in which nothing is uncertain, so that nothing is refitted."""
    fixed = copy.copy(twin)
    fixed.file = twin.file.model_copy(update={"uncertain": {}})
    rows = None if recording.written_by else frozenset(told.new_rows)
    return open_case(fixed, [recording], seed=seed, jobs=jobs, new_rows=rows)


class _Judge:
    """Scores explanations on one recording by one budget."""

    def __init__(self, case: Case, told: Predictions) -> None:
        self.case, self.told = case, told
        self.record: Record = case.simulations.records[0]
        self.first, self.rest = _parts(case)

    def confirmation(self, name: str) -> Confirmation:
        case = self.case
        points = points_of(self.told.explanations, case.setting, case.twin)
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
        sizes = _fitted(self.first, columns, directions)
        left = [
            column - np.tensordot(sizes, np.array([d[i] for d in directions]), axes=1)
            for i, column in enumerate(columns)
        ]
        blocks = [whitener.whiten(left) for whitener in self.rest]
        chi2 = float(sum(np.sum(block**2) for block in blocks))
        count = sum(block.size for block in blocks)
        nrmse = {
            signal.name: _nrmse(signal.values, left[i], [w.window.rows[i] for w in self.rest])
            for i, signal in enumerate(self.record.signals)
        }
        return Prediction(explanation.name, chi2, chi2 / count, explanation.misfit, nrmse)

    def _directions(self, point: Point, run: list[Simulated]) -> list[Direction]:
        case = self.case
        excitation = case.setting.excitation
        ratio = excitation.torque / excitation.command
        own = record_directions(self.record, run[0], case.rig.alignments)
        return own + actuator_directions(case.simulations, point, run, 0, ratio)


def _fitted(
    whiteners: Sequence[Whitener],
    columns: Sequence[NDArray[np.float64]],
    directions: Sequence[Direction],
) -> NDArray[np.float64]:
    """Size of each nuisance, in standard deviations of its prior, by the first part alone."""
    if not whiteners:
        return np.zeros(len(directions))
    target = np.concatenate([w.whiten(columns) for w in whiteners])
    matrix = np.array([np.concatenate([w.whiten(d) for w in whiteners]) for d in directions])
    normal = matrix @ matrix.T + np.eye(len(directions))
    sizes: NDArray[np.float64] = np.linalg.solve(normal, matrix @ target)
    return sizes


def _parts(case: Case) -> tuple[list[Whitener], list[Whitener]]:
    """Stretches within the first third, by which a recording is aligned, and all later ones."""
    record, budget = case.simulations.records[0], case.budget
    times = [_times(record, window) for window in budget.windows]
    start, end = min(a for a, _ in times), max(b for _, b in times)
    border = start + _ALIGNED * (end - start)
    first: list[Whitener] = []
    rest: list[Whitener] = []
    for window, covariance, (_, last) in zip(
        budget.windows, budget.covariances, times, strict=True
    ):
        (first if last <= border else rest).append(Whitener(window, covariance))
    return first, rest


def _times(record: Record, window: Window) -> tuple[float, float]:
    """[s] First and last time of a window."""
    pairs = list(zip(record.signals, window.rows, strict=True))
    first = min(float(signal.time[rows.start]) for signal, rows in pairs)
    last = max(float(signal.time[rows.stop - 1]) for signal, rows in pairs)
    return first, last


def _nrmse(values: NDArray[np.float64], left: NDArray[np.float64], rows: Sequence[slice]) -> float:
    """RMS of what is left over the range of the recorded signal, both on these rows."""
    error = np.concatenate([left[r] for r in rows])
    extent = float(np.ptp(np.concatenate([values[r] for r in rows])))
    return float(np.sqrt(np.mean(error**2))) / (extent or 1.0)
