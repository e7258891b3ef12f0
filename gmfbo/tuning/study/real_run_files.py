"""Real runs of a study, as files that are recordings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gmfbo.errors import StoreError
from gmfbo.recordings.store.study_reading import STUDY_NAME, FolderReading
from gmfbo.tuning.history.standing import UNDO, undone_numbers


def with_runs_of_studies(paths: Sequence[Path]) -> list[Path]:
    """The paths, each study folder replaced by the files of its real runs.

    Parameters
    ----------
    paths : sequence of Path
        Recordings and study folders.

    Raises
    ------
    StoreError
        A study folder cannot be read, or no real run of it ended well.
    """
    return [
        file
        for path in paths
        for file in (real_run_files(path) if (path / STUDY_NAME).is_file() else [path])
    ]


def real_run_files(folder: Path) -> list[Path]:
    """Files of the real runs that ended well and count, in the order of their numbers.

    Parameters
    ----------
    folder : Path
        Study folder.

    Raises
    ------
    StoreError
        It cannot be read, or has no such run.
    """
    study = FolderReading(folder)
    events = [event for event in study.event_lines().events if event.get("event") == UNDO]
    undone = undone_numbers(events)
    found = []
    for number in study.numbers():
        trial = study.read_trial(number)
        counts = trial.status == "ok" and not trial.bare and number not in undone
        if trial.source == "IS1" and counts:
            found.append(study.trial_path(number))
    if not found:
        raise StoreError(
            f"{folder}: expected a study with real runs, but none of it ended well and counts; "
            "give recordings instead"
        )
    return found
