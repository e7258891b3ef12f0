"""Files of a study that another program has open, as MATLAB or an HDF5 viewer does."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from gmfbo.recordings.repair.repair_folder import repair_folder
from gmfbo.recordings.store.pack import pack_study
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.example_trials import assert_same_trial, example_trial

_HOLDER = """
import sys, time, h5py
held = [h5py.File(name, sys.argv[1], locking=True) for name in sys.argv[2:]]
print("held", flush=True)
time.sleep(60)
"""


@contextmanager
def held_open(mode: str, *paths: Path) -> Iterator[None]:
    """Another process that has HDF5 files open, with the locks of HDF5."""
    with subprocess.Popen(
        [sys.executable, "-c", _HOLDER, mode, *map(str, paths)], stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "held\n"
            yield
        finally:
            process.kill()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows keeps open files from being replaced")
@pytest.mark.parametrize("mode", ["r", "r+"])
def test_a_study_is_written_read_packed_and_repaired_meanwhile(tmp_path: Path, mode: str) -> None:
    folder = tmp_path / "a.study"
    with StudyStore.create(folder, "name = 'a'\n") as store:
        store.write_trial(example_trial(1, rows=50))
    with held_open(mode, folder / "index.h5", folder / "trials" / "000001.h5"):
        with StudyStore.open_for_writing(folder) as store:
            store.write_trial(example_trial(2, rows=50))
            store.log("note")
        pack_study(folder, tmp_path / "a.h5")
        assert repair_folder(folder).lost == []
        for trial in StudyStore.open(folder).trials():
            assert_same_trial(trial, example_trial(trial.number, rows=50))
    assert StudyStore.open(folder).numbers() == StudyStore.open(tmp_path / "a.h5").numbers()
