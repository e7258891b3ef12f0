"""Look for a change of the plant after each real run, and ask for runs that would show it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np

from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.drift.drift import Drift, first_drift
from gmfbo.tuning.experiment.run_values import values_of_runs
from gmfbo.tuning.history.history import History
from gmfbo.tuning.history.incumbent import best_run
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.study_file.drift_section import DriftSection

NEXT_TO = 0.02
"""Distance in the unit cube within which a run replaces a repeat."""


@dataclass(frozen=True)
class Repeat:
    """Gains to run again.

    Attributes
    ----------
    gains : mapping of str to float
        All gains by name [unit of the FMU parameter].
    why : str
        Reason, for the user.
    """

    gains: Mapping[str, float]
    why: str


@dataclass(frozen=True, eq=False)
class DriftWatch:
    """Keeps `history.drifts` up to date.

    Attributes
    ----------
    history : History
        Runs of the study; found changes are added.
    section : DriftSection
        Section of the study file.
    """

    history: History
    section: DriftSection

    def look(self) -> Drift | None:
        """Look for changes in the real runs not weighed yet; log those found, return the last.

        Call it when the twin's run beside the last real run is on disk. Runs before the last
        logged request have been weighed already.
        """
        history, found = self.history, None
        real = history.of("IS1")
        seen = history.real_at_ask or 0
        if not self.section.watch or seen >= len(real):
            return None
        beside = [next(iter(history.children(trial, "IS2")), None) for trial in real]
        series = values_of_runs(real, beside, history.experiment)
        points = np.stack([history.unit_point(trial.gains) for trial in real])
        numbers = [trial.number for trial in real]
        for count in range(seen + 1, len(real) + 1):
            if any(drift.found_at == count for drift in history.drifts):
                continue
            start = history.drifts[-1].after_runs if history.drifts else 0
            drift = first_drift(points[:count], series, numbers, start)
            if drift is not None:
                history.store.log("drift", **asdict(drift))
                history.drifts.append(drift)
                found = drift
        return found

    def former_best(self, state: TuningState) -> Repeat | None:
        """Repeat of the best run before a change that was just found.

        The repeat shows whether these gains are still good, and so where the search starts. None
        without a new change, or where a later run was next to these gains.

        Parameters
        ----------
        state : TuningState
            State of the study; gains that are kept out are not repeated.
        """
        newest = self.history.drifts[-1] if self.history.drifts else None
        if newest is None or newest.found_at != len(self.history.of("IS1")):
            return None
        why = "repeats the best run from before the plant changed"
        return self._again(self._best_before(newest), why, state)

    def regular(self, state: TuningState) -> Repeat | None:
        """Repeat of the best of the first runs, where one is due.

        If the study asks for it, every n-th real run repeats this same run: another result at the
        same gains is the surest sign of a change.

        Parameters
        ----------
        state : TuningState
            State of the study; gains that are kept out are not repeated.
        """
        history, every = self.history, self.section.repeat_every
        real = history.of("IS1")
        if not every or (len(real) + 1) % every:
            return None
        since = [trial for trial in real if trial.number > history.changed_after]
        why = "repeats an early run, to see whether the plant has changed"
        return self._again(best_run(since[: every - 1], history.limits), why, state)

    def _again(self, trial: Trial | None, why: str, state: TuningState) -> Repeat | None:
        if trial is None:
            return None
        point = self.history.unit_point(trial.gains)
        admitted = state.keep_out.admits(point[None, :])[0]
        return Repeat(dict(trial.gains), why) if admitted else None

    def _best_before(self, drift: Drift) -> Trial | None:
        """Best run before a change; None where a later run was made next to its gains."""
        history = self.history
        before = [trial for trial in history.trials if trial.number <= drift.last_before]
        best = best_run(before, history.limits)
        made = [trial for trial in history.of("IS1") if trial.status == "ok"]
        since = [trial for trial in made if trial.number > drift.last_before]
        if best is None or not since:
            return best
        distances = np.linalg.norm(
            np.stack([history.unit_point(trial.gains) for trial in since])
            - history.unit_point(best.gains),
            axis=1,
        )
        return None if distances.min() <= NEXT_TO else best
