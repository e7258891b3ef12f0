"""Refine the twin of a study: estimate, complete by physics, and revert if it misleads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.trial import Trial
from gmfbo.retuning.believed_values import drawn_values
from gmfbo.retuning.calibration import Calibration, Estimate, RealRun, floors
from gmfbo.retuning.kept_estimate import keep_estimate, read_estimate
from gmfbo.retuning.learned_values import learned_values
from gmfbo.retuning.missing_physics import Completion
from gmfbo.retuning.real_runs import (
    compared_signals,
    plain_recordings,
    real_run,
    usable_trials,
)
from gmfbo.retuning.twin_guard import misleads
from gmfbo.retuning.unknowns import Scalar, Unknowns
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.twin_at import TwinAt
from gmfbo.tuning.drift.change_point import LEAST_BEFORE
from gmfbo.tuning.history.history import History
from gmfbo.tuning.twin.twin_version import TwinVersion

UNEXPLAINED = 3.0
"""Error of a signal over its floor, above which the diagnosis is asked."""

SURPRISE = 1.5
"""Error of a new run over the error so far, above which the twin is estimated anew."""

GROWTH = 1.5
"""Times the runs of the last estimate from which it is made anew without a surprise: what varies
from run to run, as friction does, averages out."""

STRANGE = 3.0
"""Times the error so far from which one new run may be that of a changed plant. The next one tells:
a twin estimated from runs before and after a change hides it from the watch."""

DIAGNOSED_AT = (2, 3, 5, 8, 16, 32)
"""Numbers of real runs since the plant changed at which the diagnosis may be asked again."""

MOST_DIAGNOSED = 4
"""Most real runs given to the diagnosis; later runs resemble the best one, and cost time."""


@dataclass(frozen=True, eq=False)
class _Version:
    """State of the refiner.

    Attributes
    ----------
    number : int
        0 before the first correction.
    model : FmuTwin
        The twin as given, or the augmented one.
    unknowns : Unknowns
        Its estimated parameters and tables.
    estimate : Estimate or None
        None before the first estimation.
    first : int
        Number of the last real run used by the first correction.
    last : int
        Number of the last real run used by the estimate.
    since : int
        Number of the last real run before the newest known change of the plant.
    effects : tuple of str
        Effects named by the diagnosis.
    named : tuple of mapping
        Their names, statements and probabilities.
    """

    number: int
    model: FmuTwin
    unknowns: Unknowns
    estimate: Estimate | None = None
    first: int = 0
    last: int = 0
    since: int = 0
    effects: tuple[str, ...] = ()
    named: tuple[Mapping[str, Any], ...] = ()

    @property
    def given_up(self) -> bool:
        """Whether the estimate was withdrawn, and the twin as given is in force again."""
        return self.number > 0 and self.estimate is None


class Completer(Protocol):
    """Finds a twin's missing physics; as `gmfbo.retuning.missing_physics.complete`."""

    def __call__(
        self,
        twin: FmuTwin,
        tables: Mapping[str, float],
        recordings: Sequence[Recording],
        folder: Path,
        *,
        seed: int,
    ) -> Completion | None: ...


class PhysicsRefiner:
    """Estimates uncertain parameters and tables, and asks for physics where these do not suffice.

    After the initial real runs, and after each run with a surprising error, the uncertain
    parameters and tables are estimated from all real runs since the plant changed. If the error
    is so large that the plant may have changed, the next run is awaited first. If a signal is
    still not explained, a completer adds physics: the usual one, or what a diagnosis names. A
    corrected twin that predicts the next real runs worse than the twin as given
    is withdrawn, and the twin stays as given until the plant changes.

    Parameters
    ----------
    twin : FmuTwin
        As the study file names it.
    folder : Path
        Folder for files of the versions.
    completer : callable, optional
        Adds or finds missing physics; without it, parameters and tables alone are estimated.
    asks_again : bool
        Whether the completer is asked at several numbers of runs, as a diagnosis is; otherwise
        once.
    """

    def __init__(
        self,
        twin: FmuTwin,
        folder: Path,
        completer: Completer | None = None,
        *,
        asks_again: bool = False,
    ) -> None:
        self._given, self._folder = twin, folder
        self._completer, self._asks_again = completer, asks_again
        self._newest: _Version | None = None
        self._opened: list[FmuTwin] = []

    @cached_property
    def _uncertain(self) -> Unknowns:
        """Unknowns of the twin as given, read when needed, since reading tables runs the twin."""
        return Unknowns.of(self._given)

    @property
    def _version(self) -> _Version:
        return self._newest or _Version(0, self._given, self._uncertain)

    def revise(self, history: History) -> TwinVersion | None:
        """Correct the twin by the newest real run; see `TwinRefiner`."""
        version, changed = self._version, history.changed_after != self._version.since
        if (version.given_up and not changed) or not (trials := usable_trials(history)):
            return None
        # Predictions before a change of the plant say nothing about a twin estimated after it.
        predicted = version.estimate is not None and not changed
        if predicted and misleads(history, self._given, version.first):
            return self._take_back(history)
        signals = compared_signals(trials, self._given)
        if not signals:
            return None
        runs = [real_run(t, signals, version.model, history.experiment) for t in trials]
        known = version.estimate
        seen = 0 if changed else sum(trial.number <= version.last for trial in trials)
        if known is not None and not changed and not self._calls_for_another(runs, seen, known):
            return None
        begun = known or Estimate.begin(version.unknowns, len(signals))
        estimate = Calibration(version.unknowns, runs).estimate(begun)
        reason = f"estimated from {_runs(len(runs))}"
        asks = version.model is self._given
        if self._asks_again:
            asks = any(seen < count <= len(runs) for count in DIAGNOSED_AT)
        if asks and _unexplained(estimate, runs):
            completed = self._completed(history, trials, signals, version, estimate)
            if completed is not None and _is_better(completed[1], estimate):
                version, estimate, reason = completed
        begins = changed or not version.first
        first = history.of("IS1")[-1].number if begins else version.first
        self._newest = replace(
            version,
            number=version.number + 1,
            estimate=estimate,
            first=first,
            last=trials[-1].number,
            since=history.changed_after,
        )
        return self._told(reason, signals)

    def restore(self, event: Mapping[str, Any]) -> TwinVersion:
        """Restore a logged version; see `TwinRefiner`."""
        model, unknowns = self._given, self._uncertain
        if event["augmented"] is not None:
            model = FmuTwin(
                self._folder / event["augmented"], driven_ports=self._given.driven_ports
            )
            self._opened.append(model)
            unknowns = unknowns.with_physics([Scalar(**scalar) for scalar in event["physics"]])
        estimate = None
        if not event["given_up"]:
            estimate = read_estimate(self._folder / _estimate_file(event["version"]))
        self._newest = _Version(
            number=event["version"],
            model=model,
            unknowns=unknowns,
            estimate=estimate,
            first=event["first"],
            last=event["after"],
            since=event.get("since", 0),  # an older log lacks it: any change then counts as new
            effects=tuple(event["effects"]),
            named=tuple(event.get("named", ())),  # an older log lacks it
        )
        return self._as_version(event["reason"], {})

    def close(self) -> None:
        """Close the augmented twins."""
        for twin in self._opened:
            twin.close()

    def _calls_for_another(self, runs: Sequence[RealRun], seen: int, estimate: Estimate) -> bool:
        """Whether new real runs call for another estimate: many of them, or one that surprises."""
        surprises = [self._surprise(run, estimate) for run in runs[seen:]]
        if not surprises:
            return False
        strange = surprises[-1] > STRANGE and max(surprises[:-1], default=0.0) <= SURPRISE
        if strange and len(runs) > LEAST_BEFORE:
            return False
        return max(surprises) > SURPRISE or len(runs) >= GROWTH * seen

    def _surprise(self, run: RealRun, estimate: Estimate) -> float:
        """Largest ratio over the signals of a real run's error to the error so far."""
        simulated = run.simulate(self._version.unknowns.settings(estimate.x))
        if simulated is None or len(estimate.errors) != len(simulated):
            return np.inf
        errors = np.sqrt(np.mean((simulated - run.measured) ** 2, axis=1))
        return float(np.max(errors / estimate.errors))

    def _completed(
        self,
        history: History,
        trials: Sequence[Trial],
        signals: Sequence[str],
        version: _Version,
        estimate: Estimate,
    ) -> tuple[_Version, Estimate, str] | None:
        """Estimated twin with the physics that the completer adds, and why."""
        if self._completer is None:
            return None
        values = version.unknowns.settings(estimate.x)
        names = {name for table in version.unknowns.tables for name in table.parameters}
        found = self._completer(
            self._given,
            {name: value for name, value in values.items() if name in names},
            plain_recordings(_spread(trials), self._given, history.experiment),
            self._folder / f"{self._version.number + 1:05d}",
            seed=history.study.seed,
        )
        if found is None:
            return None
        self._opened.append(found.twin)
        completed = replace(
            version,
            model=found.twin,
            unknowns=self._uncertain.with_physics(found.scalars),
            effects=found.names,
            named=found.named,
        )
        runs = [real_run(t, signals, found.twin, history.experiment) for t in trials]
        begun = _carried_over(version.unknowns, estimate, completed.unknowns, found)
        return completed, Calibration(completed.unknowns, runs).estimate(begun), found.sentence

    def _take_back(self, history: History) -> TwinVersion:
        self._newest = replace(
            self._version,
            number=self._version.number + 1,
            model=self._given,
            unknowns=self._uncertain,
            estimate=None,
            effects=(),
            named=(),
        )
        return self._told(
            "taken back: the corrected twin predicted the last real runs worse than the twin "
            "as given",
            (),
        )

    def _told(self, reason: str, signals: Sequence[str]) -> TwinVersion:
        version, estimate = self._version, self._version.estimate
        details: dict[str, Any] = {
            "first": version.first,
            "since": version.since,
            "effects": list(version.effects),
            "named": [dict(one) for one in version.named],
            "given_up": version.given_up,
            "augmented": None,
            "physics": [],
            "parameters": {},
        }
        if estimate is not None:
            keep_estimate(self._folder / _estimate_file(version.number), estimate)
            details["parameters"] = version.unknowns.settings(estimate.x)
            details["errors"] = dict(zip(signals, map(float, estimate.errors), strict=True))
            details["simulations"] = estimate.simulations
            units, given = version.model.parameter_units(), len(self._uncertain.scalars)
            details |= learned_values(version.unknowns, estimate, units, given)
        if version.model is not self._given:
            place = version.model.path.resolve().relative_to(self._folder.resolve())
            details["augmented"] = place.as_posix()
            physics = version.unknowns.scalars[len(self._uncertain.scalars) :]
            details["physics"] = [vars(scalar) for scalar in physics]
        return self._as_version(reason, details)

    def _as_version(self, reason: str, details: Mapping[str, Any]) -> TwinVersion:
        version = self._version
        if version.estimate is None:
            return TwinVersion(version.number, self._given, reason, details)
        draw = partial(drawn_values, version.unknowns, version.estimate)
        source = TwinAt(version.model, version.unknowns.settings(version.estimate.x), draw)
        return TwinVersion(version.number, source, reason, details)


def _carried_over(
    before: Unknowns, estimate: Estimate, unknowns: Unknowns, found: Completion
) -> Estimate:
    """Parameters as they were completed, or else as they were estimated; tables as estimated."""
    known = dict(zip((one.name for one in before.scalars), estimate.x, strict=False))
    tables = estimate.x[len(before.scalars) :]
    scalars = [
        one.place(found.parameters[one.name])
        if one.name in found.parameters
        else known.get(one.name, 0.0)
        for one in unknowns.scalars
    ]
    return Estimate(np.concatenate([scalars, tables]), estimate.errors, {})


def _unexplained(estimate: Estimate, runs: Sequence[RealRun]) -> bool:
    return bool(np.any(estimate.errors > UNEXPLAINED * floors(runs)))


def _spread(trials: Sequence[Trial]) -> list[Trial]:
    """The first and last trial, and some evenly between."""
    if len(trials) <= MOST_DIAGNOSED:
        return list(trials)
    places = np.linspace(0, len(trials) - 1, MOST_DIAGNOSED).round().astype(int)
    return [trials[place] for place in places]


def _is_better(one: Estimate, other: Estimate) -> bool:
    """Whether the geometric mean of the signals' errors is smaller."""
    return float(np.sum(np.log(one.errors))) < float(np.sum(np.log(other.errors)))


def _runs(count: int) -> str:
    return "1 real run" if count == 1 else f"{count} real runs"


def _estimate_file(version: int) -> str:
    return f"{version:05d}/estimate.npz"
