"""Follow a study that another process writes, from its folder alone."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from gmfbo.errors import StoreError
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.recordings.store.trial import Trial
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.run_roles import Role, Run
from gmfbo.tuning.query.progress import Phase, Progress
from gmfbo.tuning.study_file.study_file import parse_study

State = Literal["running", "ended", "interrupted"]

_PHASES: Mapping[Role, Phase] = {
    "initial": "initial",
    "survey": "initial",
    "earlier": "initial",
    "query": "query",
    "renewed": "correction",
    "beside": "correction",
    "closer": "correction",
    "corrected": "correction",
    "rejected": "correction",
}


class StudyFollower:
    """Reads new runs from a study's folder, without a lock that would disturb the writer.

    Parameters
    ----------
    folder : Path
        `NAME.study`.

    Raises
    ------
    StoreError
        There is no study, or it is a packed one.
    StudyFileError
        Its study file cannot be used.
    """

    def __init__(self, folder: Path) -> None:
        if folder.is_file():
            raise StoreError(
                f"{folder}: expected the folder of a study, got a file, which no study writes to; "
                "name the folder (NAME.study), or see a packed study with 'gmfbo report'"
            )
        self._store, self._began = StudyStore.open(folder), time.monotonic()
        label = f"{folder}: study.toml"
        name = folder.name.removesuffix(folder.suffix)
        self.file = parse_study(self._store.study_text, label=label, default_name=name)
        self._events: list[dict[str, Any]] = []
        self._trials: list[Trial] = []

    @property
    def review(self) -> StudyReview:
        """The study as read so far."""
        trials = sorted(self._trials, key=lambda trial: trial.number)
        return StudyReview.placed(self.file, self._store.location, trials, self._events)

    @property
    def state(self) -> State:
        """State of the study by its log: running, interrupted or ended."""
        if self._events and self._events[-1]["event"] == "interrupt":
            return "interrupted"
        return "ended" if self.review.ended else "running"

    def news(self) -> list[Progress]:
        """Read the runs since the last call.

        Returns
        -------
        list of Progress
            One for each new run, in order.

        Raises
        ------
        StoreError
            A trial is damaged, or the folder is gone.
        """
        # Events first: a study that has ended has all its runs on the disk.
        self._events = self._store.events()
        known = len(self.review.runs)
        seen = {trial.number for trial in self._trials}
        self._trials += [
            self._store.read_trial(number) for number in self._store.numbers() if number not in seen
        ]
        review = self.review
        return [
            self._progress(review, review.runs[: k + 1]) for k in range(known, len(review.runs))
        ]

    def _progress(self, review: StudyReview, runs: Sequence[Run]) -> Progress:
        newest = runs[-1]
        so_far = StudyReview(self.file, review.location, tuple(runs), review.events)
        best, trial = so_far.best, newest.trial
        asked = {event["number"]: event for event in so_far.logged("ask")}
        mismatch = [value for _, value in so_far.mismatch]
        return Progress(
            phase=_PHASES[newest.role],
            iteration=newest.query,
            iterations=self.file.budget.most_queries,
            is1_runs=sum(run.role != "earlier" for run in so_far.real),
            trial=trial.number,
            source=trial.source,
            gains=trial.gains,
            objective=trial.objective,
            status=trial.status,
            best_objective=best.objective if best else None,
            best_gains=best.gains if best else None,
            mismatch=mismatch[-1] if mismatch else None,
            cost=newest.cost,
            seconds=time.monotonic() - self._began,
            seconds_left=self._seconds_left(so_far),
            note=asked[trial.number]["note"] if trial.number in asked else "",
        )

    def _seconds_left(self, review: StudyReview) -> float | None:
        """[s] From the mean time between the queries so far; whichever budget ends first counts."""
        asked = [
            datetime.fromisoformat(event["time"]).timestamp()
            for event in review.logged("ask")
            if event["number"] in review.trials
        ]
        if len(asked) < 2:
            return None
        mean = (asked[-1] - asked[0]) / (len(asked) - 1)
        return mean * self.file.budget.queries_left(review.runs[-1].query, len(review.real))
