"""The experiment that every source repeats: a step, and the metrics of its response."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gmfbo.errors import RecordingError
from gmfbo.objective.metrics import METRICS, SETTLING_BAND, step_metrics, worst_metrics
from gmfbo.objective.settled import late_error, run_noise
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.reference import step_reference
from gmfbo.tuning.study_file.study_sections import ReferenceSection


@dataclass(frozen=True, eq=False)
class StepExperiment:
    """A reference with one step, and the signal whose response is scored.

    Attributes
    ----------
    reference : Recording
        Reference that the axis follows.
    signal : str
        Measured signal that is scored.
    step_time : float
        [s] Instant of the step.
    initial, step_size : float
        Reference before the step, and its height [unit of the signal].
    horizon : float
        [s] Length after the step that is scored.
    """

    reference: Recording
    signal: str
    step_time: float
    initial: float
    step_size: float
    horizon: float

    @classmethod
    def from_section(
        cls, section: ReferenceSection, signal: str, *, folder: Path, unit: str = ""
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

        Raises
        ------
        RecordingError
            The file cannot be read, or does not hold exactly one step.
        """
        if section.file is None:
            made = step_reference(
                section.step,
                at=section.at,
                horizon=section.horizon,
                sample_time=section.sample_time,
                signal=section.signal,
                unit=unit,
            )
        else:
            made = Recording.read(folder / section.file)
        return cls.from_recording(made, section.signal, signal, horizon=section.horizon)

    @classmethod
    def from_recording(
        cls, reference: Recording, reference_signal: str, signal: str, *, horizon: float
    ) -> Self:
        """Find the step in a recorded reference.

        Parameters
        ----------
        reference : Recording
            Holds one step, at least `horizon` before its end.
        reference_signal : str
            Name of the reference signal in it.
        signal : str
            Measured signal that is scored.
        horizon : float
            [s] Length after the step that is scored.

        Raises
        ------
        RecordingError
            There is not exactly one step, or too little after it.
        """
        values = reference.signal(reference_signal)
        changes = np.flatnonzero(np.diff(values)) + 1
        if changes.size != 1:
            raise RecordingError(
                f"{reference.name or 'reference'}: expected '{reference_signal}' to step once, "
                f"it changes {changes.size} times; step metrics need one step"
            )
        step_time = float(reference.time[changes[0]])
        # Times read from a file are rounded to its digits.
        if reference.time[-1] < step_time + horizon - 1e-6 * reference.duration:
            raise RecordingError(
                f"{reference.name or 'reference'}: expected {horizon:g} s after the step at "
                f"{step_time:g} s, it ends at {reference.time[-1]:g} s"
            )
        return cls(
            reference=reference,
            signal=signal,
            step_time=step_time,
            initial=float(values[0]),
            step_size=float(values[-1] - values[0]),
            horizon=horizon,
        )

    def metrics_of(self, time: ArrayLike, responses: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Metrics of many responses.

        Parameters
        ----------
        time : array_like, shape (n,)
            [s]
        responses : array_like, shape (..., n)
            The scored signal of each run.

        Returns
        -------
        dict of str to ndarray, shape (...)
            By metric [% or s].
        """
        return step_metrics(
            time,
            responses,
            step_time=self.step_time,
            step_size=self.step_size,
            initial=self.initial,
            horizon=self.horizon,
        )

    def metrics(self, run: Recording) -> dict[str, float]:
        """Metrics of one run; the worst case where it failed.

        Parameters
        ----------
        run : Recording
            With the scored signal; rows where it was not sampled are left out.

        Raises
        ------
        RecordingError, InputError
            The run succeeded but lacks the signal or ends before the horizon.
        """
        if isinstance(run, Trajectory) and run.status != "ok":
            return worst_metrics(self.horizon)
        response = run.signal(self.signal)
        sampled = ~np.isnan(response)
        if not sampled.any():
            raise RecordingError(f"{run.name or 'run'}: '{self.signal}' holds no value")
        values = self.metrics_of(run.time[sampled], response[sampled])
        return {name: float(values[name]) for name in METRICS}

    def late_error_of(
        self, time: ArrayLike, responses: ArrayLike, noise: float | None = None
    ) -> NDArray[np.float64]:
        """Late error of many responses over their tolerance, shape (...).

        Parameters
        ----------
        time : array_like, shape (n,)
            [s]
        responses : array_like, shape (..., n)
            The scored signal of each run.
        noise : float, optional
            Standard deviation of its noise [unit of the signal]; estimated unless given.
        """
        return late_error(
            time,
            responses,
            step_time=self.step_time,
            target=self.initial + self.step_size,
            step_size=self.step_size,
            horizon=self.horizon,
            band=SETTLING_BAND,
            noise=noise,
        )

    def noise(self, run: Recording) -> float:
        """Standard deviation of the noise of the scored signal [its unit] of a run that ended well.

        Parameters
        ----------
        run : Recording
            With the scored signal.
        """
        response = run.signal(self.signal)
        known = ~np.isnan(response)
        return run_noise(run.time[known], response[known], self.step_time, self.horizon)

    def late_error(self, run: Recording) -> float:
        """Late error of one run over its tolerance; infinite where it failed.

        Parameters
        ----------
        run : Recording
            With the scored signal; rows where it was not sampled are left out.
        """
        response = run.signals.get(self.signal)
        if response is None or (isinstance(run, Trajectory) and run.status != "ok"):
            return np.inf
        sampled = ~np.isnan(response)
        if not sampled.any():
            return np.inf
        return float(self.late_error_of(run.time[sampled], response[sampled]))

    @property
    def reference_size(self) -> float:
        """RMS of the reference's change over the horizon [unit of the signal].

        This is the correction's alpha. It is taken from the step on, so that the rest before the
        step does not matter; the paper's mean over the whole run gives 0.953 for a unit step.
        """
        return abs(self.step_size)
