"""A killed writer loses nothing that the store had acknowledged."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

from gmfbo.errors import StoreError
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.example_trials import assert_same_trial, example_trial
from tests.recordings.store.kill_rounds import run_kill_rounds, writing_process


@pytest.mark.parametrize("kills", [8, pytest.param(30, marks=pytest.mark.slow)])
def test_kills_lose_no_acknowledged_trial_and_leave_no_partial_one(
    tmp_path: Path, kills: int
) -> None:
    report = run_kill_rounds(tmp_path / "a.study", rounds=kills, seed=1)
    assert report.lost == []
    assert report.kills == kills
    assert report.stored >= kills


def test_a_study_is_readable_while_it_is_written(tmp_path: Path) -> None:
    folder = tmp_path / "a.study"
    StudyStore.create(folder, "").close()
    seen = 0
    with writing_process(folder) as process:
        assert process.stdout is not None
        while seen < 40:
            process.stdout.readline()
            for trial in StudyStore.open(folder).trials()[seen:]:
                assert_same_trial(trial, example_trial(trial.number))
                seen = trial.number
            with h5py.File(folder / "index.h5", "r") as index:
                for name in index["trials"]:
                    assert index["trials"][name].attrs["number"] == int(name)
        assert process.poll() is None, "readers stopped the writer"


def test_a_second_writer_is_refused_until_the_first_is_killed(tmp_path: Path) -> None:
    folder = tmp_path / "a.study"
    StudyStore.create(folder, "").close()
    with writing_process(folder) as process:
        assert process.stdout is not None
        process.stdout.readline()
        with pytest.raises(StoreError, match=f"process {process.pid} is writing this study"):
            StudyStore.open_for_writing(folder)
        process.kill()
        process.wait()
        StudyStore.open_for_writing(folder).close()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="only where processes can fork")
def test_a_forked_child_does_not_keep_the_lock_of_a_killed_writer(tmp_path: Path) -> None:
    folder = tmp_path / "a.study"
    StudyStore.create(folder, "").close()
    program = (
        "import os, sys, time\n"
        "from gmfbo.recordings.store.study_folder import StudyStore\n"
        "store = StudyStore.open_for_writing(sys.argv[1])\n"
        "child = os.fork()\n"
        "if child == 0:\n"
        "    time.sleep(30)\n"
        "print(child, flush=True)\n"
        "time.sleep(30)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program, str(folder)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        child = int(process.stdout.readline())
        process.kill()
        process.wait()
        try:
            StudyStore.open_for_writing(folder).close()
        finally:
            os.kill(child, signal.SIGKILL)
