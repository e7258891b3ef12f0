"""The real runs of a study are recordings for check and diagnose."""

from __future__ import annotations

from pathlib import Path

import pytest

from gmfbo import Recording
from gmfbo.errors import StoreError
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.tuning.history.standing import UNDO
from gmfbo.tuning.study.real_run_files import real_run_files, with_runs_of_studies
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study


def tuned(folder: Path, failing: frozenset[int] = frozenset()) -> Path:
    """A finished study of four real runs."""
    study = write_study(folder, budget="is1_runs = 4")
    with Tuner(study, is1=AnalyticAxis(failing=failing), is2=AnalyticAxis(inertia=0.2)) as tuner:
        tuner.run()
    return study.location


def test_a_study_stands_for_its_real_runs_in_order(tmp_path: Path) -> None:
    folder = tuned(tmp_path)
    files = with_runs_of_studies([Path("first.csv"), folder])
    assert files[0] == Path("first.csv")
    with StudyStore.open(folder) as store:
        real = [trial for trial in store.trials() if trial.source == "IS1"]
    read = [Recording.read(file) for file in files[1:]]
    assert [one.parameters for one in read] == [trial.gains for trial in real]


def test_failed_runs_and_those_taken_back_are_left_out(tmp_path: Path) -> None:
    folder = tuned(tmp_path, frozenset({2}))
    files = real_run_files(folder)
    assert len(files) == 3
    with StudyStore.open_for_writing(folder) as store:
        store.log(UNDO, trials=[int(files[-1].stem)])
    assert real_run_files(folder) == files[:-1]


def test_a_study_without_a_real_run_is_refused(tmp_path: Path) -> None:
    folder = tuned(tmp_path, frozenset(range(1, 30)))
    with pytest.raises(StoreError, match="none of it ended well"):
        real_run_files(folder)
