"""The experiment that every source repeats: one reference, and the metrics of the response."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gmfbo.errors import RecordingError
from gmfbo.objective.metrics import METRICS, step_metrics, worst_metrics
from gmfbo.objective.smoothing import smoothed
from gmfbo.objective.tracking import (
    COMMAND_METRICS,
    TRACKING_METRICS,
    command_metrics,
    spent_energy,
    tracking_metrics,
)
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.reference import followed_signal
from gmfbo.tuning.experiment.made_reference import made_reference
from gmfbo.tuning.experiment.scoring_terms import DEFAULT_TERMS, ScoringTerms
from gmfbo.tuning.study_file.reference_section import ReferenceSection


@dataclass(frozen=True)
class Step:
    """A step within a reference.

    Attributes
    ----------
    time : float
        [s] When it comes.
    initial, size : float
        Reference before it, and its height [unit of the signal].
    horizon : float
        [s] Length after it that is scored as its response.
    """

    time: float
    initial: float
    size: float
    horizon: float


@dataclass(frozen=True, eq=False)
class ReferenceExperiment:
    """A reference, and the signal whose response is scored.

    Attributes
    ----------
    reference : Recording
        Reference that the axis follows; a disturbance is a second signal in it.
    signal : str
        Measured signal that is scored.
    begin, horizon : float
        [s] Begin and length of the part that is scored.
    steps : tuple of Step
        Steps of the reference; empty where it is none of steps.
    terms : ScoringTerms
        What else is scored, and how.
    """

    reference: Recording
    signal: str
    begin: float
    horizon: float
    steps: tuple[Step, ...] = ()
    terms: ScoringTerms = DEFAULT_TERMS

    @classmethod
    def from_section(
        cls,
        section: ReferenceSection,
        signal: str,
        *,
        folder: Path,
        unit: str = "",
        terms: ScoringTerms = DEFAULT_TERMS,
    ) -> Self:
        """Make the experiment that a study file describes.

        Parameters
        ----------
        section : ReferenceSection
            The part `[reference]`.
        signal : str
            Measured signal that is scored.
        folder : Path
            Folder to which a path in the section is relative.
        unit : str
            SI unit of the reference.
        terms : ScoringTerms
            What else is scored, and how.

        Raises
        ------
        RecordingError
            The file cannot be read, or ends before the horizon.
        InputError
            The section describes no reference.
        """
        made = made_reference(section, folder, unit)
        kind, stated = section.chosen, "horizon" in section.model_fields_set
        one_step = _jumps(made.signal(section.signal)).size == 1
        whole = kind == "sine" or (kind == "file" and not (stated or one_step))
        return cls.from_recording(
            made,
            signal,
            horizon=None if whole else section.horizon,
            several=kind == "steps",
            terms=terms,
        )

    @classmethod
    def from_recording(
        cls,
        reference: Recording,
        signal: str,
        *,
        horizon: float | None = None,
        several: bool = False,
        terms: ScoringTerms = DEFAULT_TERMS,
    ) -> Self:
        """Find in a reference what is scored.

        Scored is from the first change of the reference, or of a disturbance, on.

        Parameters
        ----------
        reference : Recording
            Its first signal is the reference, others are disturbances.
        signal : str
            Measured signal that is scored.
        horizon : float or None
            [s] Length that is scored after the first change, or with `several` after the last;
            None takes all there is.
        several : bool
            Every change of the reference is a step; otherwise a reference that changes more than
            once has none.
        terms : ScoringTerms
            What else is scored, and how.

        Raises
        ------
        RecordingError
            Nothing in it changes, or it ends before the horizon.
        """
        values = reference.signal(followed_signal(reference))
        rows, label = _jumps(values), reference.name or "reference"
        changes = np.concatenate([rows, *map(_jumps, _disturbances(reference))])
        if changes.size == 0:
            raise RecordingError(
                f"{label}: expected a reference that changes, or a disturbance; it is constant"
            )
        begin, last = float(reference.time[changes.min()]), float(reference.time[-1])
        if rows.size == 0 or horizon is None:
            return cls(reference, signal, begin, last - begin, (), terms)
        counted = float(reference.time[rows[-1 if several else 0]])
        # Times read from a file are rounded to its digits.
        if last < counted + horizon - 1e-6 * reference.duration:
            what = "the step" if rows.size == 1 else "the change"
            raise RecordingError(
                f"{label}: expected {horizon:g} s after {what} at {counted:g} s, it ends at "
                f"{last:g} s"
            )
        steps = _steps(reference.time, values, rows, horizon) if several or rows.size == 1 else ()
        scored = horizon if counted == begin else counted + horizon - begin
        return cls(reference, signal, begin, scored, steps, terms)

    @property
    def reference_signal(self) -> str:
        """Name of the signal that is followed."""
        return followed_signal(self.reference)

    @property
    def described(self) -> str:
        """The reference in words: `reference from 0 to 1 rad at 0.1 s`."""
        name = self.reference_signal
        unit = self.reference.units.get(name, "")
        if not self.steps:
            text = f"{name} as in {self.reference.name}"
        elif len(self.steps) == 1:
            (step,) = self.steps
            to = f"{step.initial:g} to {step.initial + step.size:g} {unit}".strip()
            text = f"{name} from {to} at {step.time:g} s"
        else:
            levels = ", ".join(f"{step.initial + step.size:g}" for step in self.steps)
            times = ", ".join(f"{step.time:g}" for step in self.steps)
            text = f"{name} from {self.steps[0].initial:g} to {levels} {unit}".rstrip()
            text += f" at {times} s"
        for other in self._disturbances:
            values = self.reference.signals[other]
            at = float(self.reference.time[_jumps(values)[0]])
            text += f", {other} of {values[-1]:g} from {at:g} s on"
        return text

    def target(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Reference at given times, held between its rows, shape (m,) [unit of the signal].

        Parameters
        ----------
        times : ndarray, shape (m,)
            [s]
        """
        reference = self.reference
        slack = 1e-6 * reference.duration / max(len(reference) - 1, 1)
        rows = np.searchsorted(reference.time, times + slack, side="right") - 1
        return reference.signals[self.reference_signal][np.maximum(rows, 0)]

    def metrics_of(
        self, time: ArrayLike, responses: ArrayLike, names: Collection[str] | None = None
    ) -> dict[str, NDArray[np.float64]]:
        """Metrics of many responses.

        Parameters
        ----------
        time : array_like, shape (n,)
            [s]
        responses : array_like, shape (..., n)
            The scored signal of each run.
        names : collection of str, optional
            What is needed; others may be left out. All unless given.

        Returns
        -------
        dict of str to ndarray, shape (...)
            By metric; step metrics where there is a step. Metrics of the command are NaN.
        """
        times = np.asarray(time, dtype=float)
        values = smoothed(times, responses, self.terms.filter_s)
        found: dict[str, NDArray[np.float64]] = {}
        if names is None or not set(METRICS).isdisjoint(names):
            found |= self._step_metrics(times, values)
        if names is None or not set(TRACKING_METRICS).isdisjoint(names):
            error = self.target(times) - values
            found |= tracking_metrics(times, error, begin=self.begin, horizon=self.horizon)
        unknown = np.full(values.shape[:-1], np.nan)
        return found | {name: unknown for name in COMMAND_METRICS if self.terms.command}

    def _step_metrics(
        self, time: NDArray[np.float64], values: NDArray[np.float64]
    ) -> dict[str, NDArray[np.float64]]:
        """Step metrics; of several steps the largest of each."""
        each = [
            step_metrics(
                time,
                values,
                step_time=step.time,
                step_size=step.size,
                initial=step.initial,
                horizon=step.horizon,
                band=self.terms.band,
            )
            for step in self.steps
        ]
        if not each:
            return {}
        return {name: np.max([one[name] for one in each], axis=0) for name in METRICS}

    def metrics(self, run: Recording) -> dict[str, float]:
        """Metrics of one run; where it failed the worst case, which is infinite if unknown.

        Parameters
        ----------
        run : Recording
            With the scored signal; rows where it was not sampled are left out.

        Raises
        ------
        RecordingError, InputError
            The run succeeded but lacks a signal or ends before the horizon.
        """
        if isinstance(run, Trajectory) and run.status != "ok":
            return {**self.worst, **dict.fromkeys(self.without_worst, np.inf)}
        time, response = _sampled(run, self.signal)
        values = {n: float(v) for n, v in self.metrics_of(time, response).items()}
        return {**values, **self._command_metrics(run)}

    def _command_metrics(self, run: Recording) -> dict[str, float]:
        """Metrics of the command; none where it is unknown or was not recorded."""
        name = self.terms.command
        if name is None:
            return {}
        if name not in run.signals:
            return dict.fromkeys(COMMAND_METRICS, np.nan)
        time, command = _sampled(run, name)
        part = {"begin": self.begin, "horizon": self.horizon}
        jumps = [step.time for step in self.steps]
        jumps += [
            float(self.reference.time[row])
            for name in self._disturbances
            for row in _jumps(self.reference.signals[name])
        ]
        found = command_metrics(time, command, jumps=jumps, **part)
        velocity = self.terms.velocity if self.terms.velocity in run.signals else None
        moved, motion = _sampled(run, velocity or self.signal)
        motion = smoothed(moved, motion, self.terms.filter_s)
        along = np.interp(time, moved, motion)
        energy = spent_energy(time, command, along, is_velocity=velocity is not None, **part)
        return {**found, "energy": energy}

    @property
    def worst(self) -> dict[str, float]:
        """Step metrics assigned to a failed run [% or s]; empty without a step."""
        return worst_metrics(max(step.horizon for step in self.steps)) if self.steps else {}

    @property
    def without_worst(self) -> tuple[str, ...]:
        """Metrics that have no worst case of their own."""
        return (*TRACKING_METRICS, *(COMMAND_METRICS if self.terms.command else ()))

    @property
    def reference_size(self) -> float:
        """RMS of the reference's change over the scored part [unit of the signal].

        This is the correction's alpha. It is taken from the first change on, so that the rest
        before does not matter; the paper's mean over the whole run gives 0.953 for a unit step.
        """
        if len(self.steps) == 1:
            return abs(self.steps[0].size)
        values = self.reference.signals[self.reference_signal]
        scored = self.reference.time >= self.begin
        return float(np.sqrt(np.mean((values[scored] - values[0]) ** 2)))

    @property
    def _disturbances(self) -> list[str]:
        return list(self.reference.signals)[1:]


def _jumps(values: NDArray[np.float64]) -> NDArray[np.int_]:
    """Rows at which a signal changes."""
    return np.flatnonzero(np.diff(values)) + 1


def _disturbances(reference: Recording) -> list[NDArray[np.float64]]:
    return list(reference.signals.values())[1:]


def _steps(
    time: NDArray[np.float64], values: NDArray[np.float64], rows: NDArray[np.int_], horizon: float
) -> tuple[Step, ...]:
    """Steps at these rows, each scored until the next one comes, the last for the horizon."""
    times = [float(time[row]) for row in rows]
    horizons = [*(after - before for before, after in pairwise(times)), horizon]
    return tuple(
        Step(
            time=float(time[row]),
            initial=float(values[row - 1]),
            size=float(values[row] - values[row - 1]),
            horizon=length,
        )
        for row, length in zip(rows, horizons, strict=True)
    )


def _sampled(run: Recording, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times and values of a signal where it was sampled."""
    values = run.signal(name)
    sampled = ~np.isnan(values)
    if not sampled.any():
        raise RecordingError(f"{run.name or 'run'}: '{name}' holds no value")
    return run.time[sampled], values[sampled]
