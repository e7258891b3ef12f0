"""A study: its file, and its runs so far."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from gmfbo.errors import StoreError, StudyFileError
from gmfbo.objective.cost import Objective
from gmfbo.objective.limits import Limits
from gmfbo.objective.metric_words import MetricWords
from gmfbo.objective.metrics import worst_metrics
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.drift.drift import Drift
from gmfbo.tuning.history.incumbent import best_run
from gmfbo.tuning.history.standing import UNDO, standing_events, undone_numbers
from gmfbo.tuning.query.method import Recommendation
from gmfbo.tuning.study_file.study_file import as_begun, parse_study, read_study_file
from gmfbo.tuning.study_file.study_sections import StudyFile

if TYPE_CHECKING:
    from gmfbo.recordings.store.memory_store import TrialStore
    from gmfbo.recordings.store.study_folder import StudyStore


OBJECTIVE_VERSION = 3
"""Version that a new study begins with; a study begun before goes on as it was.

In version 1, which states none, a failed run has a price. Since version 2 runs are ranked before
their cost counts. Since version 3 runs of the twin around a real one are corrected only by methods
that use the correction, and the last runs may confirm the recommended gains.
"""


@dataclass(frozen=True, eq=False)
class Study:
    """A tuning study, begun or not.

    Attributes
    ----------
    file : StudyFile
        The validated study file.
    text : str
        The study file as given.
    origin : Path
        Folder to which paths in the file are relative.
    location : Path
        The study's folder, or a packed file; need not exist yet.
    """

    file: StudyFile
    text: str = field(repr=False)
    origin: Path
    location: Path

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a study file, a study's folder or a packed study.

        Parameters
        ----------
        path : str or Path
            `.toml`, `NAME.study/` or `.h5`.

        Raises
        ------
        StudyFileError
            The study file cannot be used.
        StoreError
            The folder or packed file is none of a study.
        """
        from gmfbo.recordings.store.study_folder import StudyStore

        path = Path(path)
        if path.suffix.lower() == ".toml":
            file, text = read_study_file(path)
            folder = path.parent / file.folder_name
            return cls(as_begun(file, _events_of(folder)), text, path.parent, folder)
        with StudyStore.open(path) as store:
            text, events = store.study_text, store.events()
        name = path.name.removesuffix(path.suffix)
        file = parse_study(text, label=f"{path}: study.toml", default_name=name)
        begun = [event for event in events if event["event"] == "begin"]
        origin = path / begun[-1]["origin"] if begun else path.parent
        return cls(as_begun(file, events), text, origin, path)

    @property
    def begun(self) -> bool:
        """Whether anything was recorded."""
        return self.location.exists()

    @property
    def trials(self) -> tuple[Trial, ...]:
        """All runs on disk in order; read anew each time, also while the study runs."""
        if not self.begun:
            return ()
        from gmfbo.recordings.store.study_folder import StudyStore

        with StudyStore.open(self.location) as store:
            return tuple(store.trials())

    @property
    def best(self) -> Trial | None:
        """Real run with the least cost, those that meet the limits first; None without any."""
        since = self.drifts[-1].last_before if self.drifts else 0
        undone = self.taken_back
        counted = [trial for trial in self.trials if trial.number not in undone]
        return best_run(counted, Limits(self.file.constraints), since)

    @property
    def taken_back(self) -> frozenset[int]:
        """Numbers of the trials that were taken back: on disk, but counted no more."""
        return undone_numbers(self._logged(UNDO))

    @property
    def drifts(self) -> tuple[Drift, ...]:
        """Changes of the plant that were found while it was tuned, in order."""
        return tuple(Drift.logged(event) for event in self._logged("drift"))

    @property
    def recommendation(self) -> Recommendation | None:
        """Gains that the surrogate recommended last; None before a run of the study ended."""
        logged = self._last("recommendation")
        if logged is None:
            return None
        return Recommendation(logged["gains"], logged["mean"], logged["std"])

    @property
    def objective(self) -> Objective | None:
        """The cost with its constants; None before the initial twin runs are complete."""
        logged = self._last("normalise")
        if logged is None:
            return None
        return Objective(
            self.file.objective.weights,
            logged["mean"],
            logged["std"],
            # Studies of one reference and no metrics of the user's own did not log it.
            logged.get("worst") or worst_metrics(self.file.reference.horizon),
        )

    @property
    def metric_units(self) -> dict[str, str]:
        """Unit of each metric that depends on the signals, and of the user's own as stated.

        Studies of former versions logged none.
        """
        logged = (self._last("normalise") or {}).get("units", {})
        return {**logged, **self.file.objective.units}

    @property
    def metric_words(self) -> MetricWords:
        """Words for metrics; before the initial twin runs are complete, all are numbers."""
        known = self.objective
        horizons = [reference.horizon for reference in self.file.references] if known else []
        return MetricWords.of(self.metric_units, known.worst if known else {}, horizons)

    @property
    def earlier_logged(self) -> dict[str, Any] | None:
        """Which runs of an earlier study are taken over; None before that was decided."""
        return self._last("earlier")

    def open_for_writing(self, *, resume: bool) -> StudyStore:
        """Open the study's folder, or make it.

        Parameters
        ----------
        resume : bool
            Go on with a study that holds trials; otherwise it is refused.

        Raises
        ------
        StoreError
            The folder cannot be written, another process writes it, or it holds trials.
        StudyFileError
            It was begun with another study file.
        """
        from gmfbo.recordings.store.study_folder import StudyStore

        if not self.begun:
            return StudyStore.create(self.location, self.text)
        store = StudyStore.open_for_writing(self.location)
        try:
            self._check_begun(store, resume)
        except Exception:
            store.close()
            raise
        return store

    def _check_begun(self, store: StudyStore, resume: bool) -> None:
        if not resume and store.next_number() > 1:
            raise StoreError(
                f"{self.location}: holds {store.next_number() - 1} trials already; go on with "
                "them by --resume, or give another 'out'"
            )
        label = f"{self.location}/study.toml"
        text = parse_study(store.study_text, label=label, default_name=self.file.name)
        begun_with = as_begun(text, store.events())
        differing = _differing(begun_with, self.file)
        if differing:
            raise StudyFileError(
                f"{self.location}: begun with another {', '.join(differing)}; "
                f"only the end of the [budget] may change; give another 'out'"
            )

    def log_begin(self, store: TrialStore, twins: dict[str, str], told: Mapping[str, Any]) -> None:
        """Log who runs, and refuse to mix runs of different twins in one study.

        Parameters
        ----------
        store : TrialStore
            Open for writing.
        twins : dict of str to str
            Content hash by source.
        told : mapping of str to object
            What is logged of the gains: `units`, and `box` with the range of each tuned one.

        Raises
        ------
        StudyFileError
            A twin differs from the one that the study was begun with.
        """
        begun = [event for event in store.events() if event["event"] == "begin"]
        for source, content in twins.items():
            before = begun[-1]["twins"].get(source, content) if begun else content
            if content != before:
                what = "[objective] metrics" if source == "metrics" else f"the twin of {source}"
                raise StudyFileError(
                    f"{self.location}: {what} has changed since the study was begun; bring it "
                    "back, or give another 'out'"
                )
        origin = os.path.relpath(self.origin.resolve(), self.location.resolve())
        first: dict[str, Any] = {}
        if not begun:
            first = {"objective_version": OBJECTIVE_VERSION, "method": self.file.method}
        place = Path(origin).as_posix()
        store.log("begin", origin=place, twins=twins, **told, **first)

    @staticmethod
    def objective_version(store: TrialStore) -> int:
        """Version of the objective by which a study was begun, or by which a new one begins.

        Parameters
        ----------
        store : TrialStore
            Of the study.
        """
        begun = [event for event in store.events() if event["event"] == "begin"]
        return int(begun[0].get("objective_version", 1)) if begun else OBJECTIVE_VERSION

    def _last(self, event: str) -> dict[str, Any] | None:
        logged = self._logged(event)
        return logged[-1] if logged else None

    def _logged(self, event: str) -> list[dict[str, Any]]:
        if not self.begun:
            return []
        from gmfbo.recordings.store.study_folder import StudyStore

        with StudyStore.open(self.location) as store:
            events = store.events()
            if event != UNDO and any(entry["event"] == UNDO for entry in events):
                events = standing_events(events, store.numbers())
        return [entry for entry in events if entry["event"] == event]

    def __repr__(self) -> str:
        trials, best = self.trials, self.best
        count = {s: sum(t.source == s for t in trials) for s in ("IS1", "IS2", "IS3")}
        runs = ", ".join(f"{number} {source}" for source, number in count.items())
        head = f"<Study '{self.file.name}': {self.file.method}, seed {self.file.seed}, {runs} runs"
        if best is None:
            return head + ">"
        gains = ", ".join(f"{name} = {value:.4g}" for name, value in best.gains.items())
        return f"{head}, best g = {best.objective:.4g} at {gains}>"


def _events_of(folder: Path) -> list[dict[str, Any]]:
    """Log of a study that was begun there; what is wrong with it is told when it is opened."""
    from gmfbo.recordings.store.study_reading import FolderReading

    try:
        return FolderReading(folder).event_lines().events
    except StoreError:
        return []


def _differing(one: StudyFile, other: StudyFile) -> list[str]:
    """Parts in which two study files differ, apart from where they are kept and when they end."""

    def decisive(study: StudyFile) -> dict[str, Any]:
        parts = study.model_dump(exclude={"name", "out"})
        for end in ("iterations", "is1_runs", "is2_runs", "is2_seconds"):
            del parts["budget"][end]
        for patience in ("time_limit", "retries"):
            del parts["is1"][patience]
        return parts

    first, second = decisive(one), decisive(other)
    return [f"[{name}]" for name in first if first[name] != second[name]]
