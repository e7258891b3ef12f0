"""Several references in one objective: each is played alone, the responses are joined."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gmfbo.errors import OwnMetricsError, RecordingError
from gmfbo.objective.metrics import worst_metrics
from gmfbo.objective.own_metrics import OwnMetrics
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.tuning.experiment.experiment import ReferenceExperiment
from gmfbo.tuning.experiment.joined_runs import join_runs
from gmfbo.tuning.experiment.late_errors import late_error_of, late_error_of_run, noise_of_run
from gmfbo.tuning.experiment.scoring_terms import DEFAULT_TERMS, ScoringTerms
from gmfbo.tuning.study_file.reference_section import ReferenceSection


@dataclass(frozen=True, eq=False)
class ExperimentSeries:
    """The experiment of every source: one or several references, and metrics of the responses.

    Each reference is a run of its own from rest. The runs of one query are joined to one
    recording, the second after the first, so that a trial holds them all. A series of one
    reference behaves as that reference.

    Attributes
    ----------
    parts : tuple of ReferenceExperiment
        One for each reference, at least one.
    shares : tuple of float
        Weight of each reference in the cost; they sum to one.
    own : OwnMetrics or None
        Metrics by a function of the user.
    """

    parts: tuple[ReferenceExperiment, ...]
    shares: tuple[float, ...] = (1.0,)
    own: OwnMetrics | None = None

    @classmethod
    def from_sections(
        cls,
        sections: Sequence[ReferenceSection],
        signal: str,
        *,
        folder: Path,
        unit: str = "",
        own: OwnMetrics | None = None,
        terms: ScoringTerms = DEFAULT_TERMS,
    ) -> Self:
        """Make the series that a study file describes.

        Parameters
        ----------
        sections : sequence of ReferenceSection
            The parts `[reference]`.
        signal : str
            Measured signal that is scored.
        folder : Path
            Folder to which a path in a section is relative.
        unit : str
            SI unit of the references.
        own : OwnMetrics, optional
            Metrics by a function of the user.
        terms : ScoringTerms
            What else is scored, and how.

        Raises
        ------
        RecordingError
            A file cannot be read, or ends before the horizon.
        InputError
            A section describes no reference.
        """
        parts = tuple(
            ReferenceExperiment.from_section(section, signal, folder=folder, unit=unit, terms=terms)
            for section in sections
        )
        total = sum(section.weight for section in sections)
        return cls(parts, tuple(section.weight / total for section in sections), own)

    @property
    def signal(self) -> str:
        """Measured signal that is scored."""
        return self.parts[0].signal

    @property
    def reference(self) -> Recording:
        """The first reference; the only one of most studies."""
        return self.parts[0].reference

    @property
    def references(self) -> tuple[Recording, ...]:
        """References that the axis follows, one after the other."""
        return tuple(part.reference for part in self.parts)

    @property
    def terms(self) -> ScoringTerms:
        """What is scored beside the signal, and how."""
        return self.parts[0].terms

    @property
    def offsets(self) -> NDArray[np.float64]:
        """[s] Offset of each reference's time in the joined recording, shape (p,)."""
        starts = [0.0]
        for before, after in pairwise(self.references):
            end = float(before.time[-1]) + starts[-1]
            gap = float(before.time[-1] - before.time[-2])
            starts.append(end + gap - float(after.time[0]))
        return np.array(starts)

    def scored_times(self, count: int) -> NDArray[np.float64]:
        """Instants at which a joined trajectory is scored.

        Parameters
        ----------
        count : int
            Number of instants, at least two a reference.

        Returns
        -------
        ndarray, shape (m,)
            [s] Increasing; m is at most `count`, evenly spaced within each horizon.
        """
        starts = self.offsets + [part.begin for part in self.parts]
        since, _ = self.after_step(count)
        return np.repeat(starts, since.size // len(self.parts)) + since

    def after_step(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Time since the first change, and target, at each of `scored_times`.

        Parameters
        ----------
        count : int
            As for `scored_times`.

        Returns
        -------
        since : ndarray, shape (m,)
            [s] Time since the first change of each reference.
        target : ndarray, shape (m,)
            [unit of the signal] Reference at that time.
        """
        each = max(count // len(self.parts), 2)
        since = [np.linspace(0.0, part.horizon, each) for part in self.parts]
        targets = [
            part.target(part.begin + after) for part, after in zip(self.parts, since, strict=True)
        ]
        return np.concatenate(since), np.concatenate(targets)

    def join(self, runs: Sequence[Recording]) -> Recording:
        """Join the runs of one query.

        Parameters
        ----------
        runs : sequence of Recording
            In the order of the references; fewer where one failed.

        Raises
        ------
        RecordingError
            There are more runs than references, or fewer though none failed.
        """
        if len(self.parts) == 1 and len(runs) == 1:
            return runs[0]
        whole = not any(isinstance(run, Trajectory) and run.status != "ok" for run in runs)
        if not 0 < len(runs) <= len(self.parts) or (whole and len(runs) < len(self.parts)):
            raise RecordingError(
                f"expected {len(self.parts)} recordings, one a [[reference]], got {len(runs)}"
            )
        spans = [(float(each.time[0]), float(each.time[-1])) for each in self.references]
        return join_runs(runs, self.offsets, spans)

    def metrics_of(
        self, time: ArrayLike, responses: ArrayLike, names: Collection[str] | None = None
    ) -> dict[str, NDArray[np.float64]]:
        """Metrics of many responses.

        Parameters
        ----------
        time : array_like, shape (n,)
            [s] Joined, see `scored_times`.
        responses : array_like, shape (..., n)
            The scored signal of each run.
        names : collection of str, optional
            What is needed; others may be left out. All unless given.

        Returns
        -------
        dict of str to ndarray, shape (...)
            By metric [% or s]. Several references give their weighted mean, and `NAME[1]`,
            `NAME[2]` ... of each. A user's metric that needs other signals is NaN.
        """
        times, values = np.asarray(time, dtype=float), np.asarray(responses, dtype=float)
        asked = None if names is None else {name.partition("[")[0] for name in names}
        each = []
        for number, part in enumerate(self.parts):
            rows, own_times = self._slot(times, number)
            found = part.metrics_of(own_times, values[..., rows], asked)
            if self.own and (asked is None or not self.own.required.isdisjoint(asked)):
                found |= self._own_of(own_times, values[..., rows], part)
            each.append(found)
        return _combined(each, self.shares)

    def metrics(self, run: Recording) -> dict[str, float]:
        """Metrics of one joined run; the worst case where it failed.

        A user's own metrics of a failed run are infinite here; the constants of the cost replace
        them later.

        Parameters
        ----------
        run : Recording
            With the scored signal; rows where it was not sampled are left out.

        Raises
        ------
        RecordingError, InputError
            The run succeeded but lacks the signal or ends before the horizon.
        OwnMetricsError
            The user's own function refused the run.
        """
        each = []
        for number, part in enumerate(self.parts):
            if isinstance(run, Trajectory) and run.status != "ok":
                own = dict.fromkeys(self.own.required if self.own else (), np.inf)
                each.append({**part.metrics(run), **own})
                continue
            alone = self.part_of(run, number)
            of_own = self.own.of(alone) if self.own else {}
            each.append({**part.metrics(alone), **of_own})
        return {name: float(value) for name, value in _combined(each, self.shares).items()}

    def late_error_of(
        self, time: ArrayLike, responses: ArrayLike, noise: float | None = None
    ) -> NDArray[np.float64]:
        """Largest late error of many responses over the references, shape (...).

        Parameters
        ----------
        time : array_like, shape (n,)
            [s] Joined, see `scored_times`.
        responses : array_like, shape (..., n)
            The scored signal of each run.
        noise : float, optional
            Standard deviation of its noise [unit of the signal]; estimated unless given.
        """
        times, values = np.asarray(time, dtype=float), np.asarray(responses, dtype=float)
        each = []
        for number, part in enumerate(self.parts):
            rows, own_times = self._slot(times, number)
            each.append(late_error_of(part, own_times, values[..., rows], noise))
        return np.asarray(np.max(each, axis=0))

    def noise(self, run: Recording) -> float:
        """Largest noise of the scored signal over the references [its unit].

        Parameters
        ----------
        run : Recording
            Joined; it ended well.
        """
        return max(noise_of_run(part, self.part_of(run, k)) for k, part in enumerate(self.parts))

    def late_error(self, run: Recording) -> float:
        """Largest late error of one run over the references; infinite where it failed.

        Parameters
        ----------
        run : Recording
            Joined; at most 1 where it settled after each reference.
        """
        if isinstance(run, Trajectory) and run.status != "ok":
            return np.inf
        parts = enumerate(self.parts)
        return max(late_error_of_run(part, self.part_of(run, k)) for k, part in parts)

    def part_of(self, run: Recording, number: int) -> Recording:
        """Part of a joined run with one reference (counted from 0), at its own times."""
        if len(self.parts) == 1:
            return run
        rows, times = self._slot(run.time, number)
        if not rows.any():
            raise RecordingError(f"{run.name or 'run'}: nothing of reference {number + 1} in it")
        return Recording(
            time=times,
            signals={name: values[rows] for name, values in run.signals.items()},
            units=run.units,
            name=run.name,
            parameters=run.parameters,
        )

    @property
    def worst(self) -> dict[str, float]:
        """Step metrics assigned to a failed run [% or s]; empty where no reference steps."""
        stepping = [
            (share, max(step.horizon for step in part.steps))
            for share, part in zip(self.shares, self.parts, strict=True)
            if part.steps
        ]
        if not stepping:
            return {}
        shares, horizons = zip(*stepping, strict=True)
        return worst_metrics(float(np.dot(shares, horizons)) / _whole(shares))

    @property
    def metric_names(self) -> tuple[str, ...]:
        """Metrics that can be computed of a run, without those of a user's function."""
        names = [name for part in self.parts for name in (*part.worst, *part.without_worst)]
        return tuple(dict.fromkeys(names))

    @property
    def reference_size(self) -> float:
        """RMS of the references' changes over their horizons [unit of the signal]."""
        squares = [part.reference_size**2 for part in self.parts]
        return float(np.sqrt(np.dot(self.shares, squares)))

    def _slot(
        self, time: NDArray[np.float64], number: int
    ) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """Rows of a joined time that belong to a reference, and their times in it."""
        if len(self.parts) == 1:
            return np.ones(time.shape, dtype=bool), time
        reference, own = self.references[number], time - self.offsets[number]
        slack = 0.5 * float(reference.time[-1] - reference.time[-2])
        rows = (own >= reference.time[0] - slack) & (own <= reference.time[-1] + slack)
        return rows, own[rows]

    def _own_of(
        self, time: NDArray[np.float64], responses: NDArray[np.float64], part: ReferenceExperiment
    ) -> Mapping[str, NDArray[np.float64]]:
        """User's metrics of bare responses; NaN where they need other signals."""
        if self.own is None:
            return {}
        flat = responses.reshape(-1, time.size)
        names = sorted(self.own.required)
        found = {name: np.full(len(flat), np.nan) for name in names}
        commands = {
            name: np.interp(time, part.reference.time, values)
            for name, values in part.reference.signals.items()
        }
        for row in np.flatnonzero(np.isfinite(flat).all(axis=1)):
            run = Recording(time=time, signals={**commands, part.signal: flat[row]})
            try:
                values = self.own.of(run)
            except OwnMetricsError:
                continue
            for name in names:
                found[name][row] = values[name]
        return {name: values.reshape(responses.shape[:-1]) for name, values in found.items()}


def _whole(shares: Sequence[float]) -> float:
    """Sum of shares, exactly one where they are all shares of a series."""
    total = float(sum(shares))
    return 1.0 if np.isclose(total, 1.0) else total


def _combined(
    each: Sequence[Mapping[str, ArrayLike]], shares: Sequence[float]
) -> dict[str, NDArray[np.float64]]:
    """Weighted means, followed by the metrics of each reference where there are several.

    A metric that only some references have, such as the overshoot of a step beside a sine, is
    the mean over these.
    """
    names = list(dict.fromkeys(name for one in each for name in one))
    if len(each) == 1:
        return {name: np.asarray(each[0][name], dtype=float) for name in names}
    mean: dict[str, NDArray[np.float64]] = {}
    single: dict[str, NDArray[np.float64]] = {}
    for name in names:
        having = [k for k, one in enumerate(each) if name in one]
        values = [np.asarray(each[k][name], dtype=float) for k in having]
        weights = [shares[k] for k in having]
        total = sum(weight * value for weight, value in zip(weights, values, strict=True))
        mean[name] = np.asarray(total / _whole(weights))
        single |= {f"{name}[{k + 1}]": value for k, value in zip(having, values, strict=True)}
    return {**mean, **single}
