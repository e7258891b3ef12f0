"""A full or read-only disk: one clear error, nothing lost, nothing left over."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from gmfbo.errors import RecordingError, StoreError
from gmfbo.recordings.recording import read_recording
from gmfbo.recordings.store.pack import pack_study
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.recordings.writing.writer import write_recording
from tests.recordings.store.example_trials import assert_same_trial, example_trial


def store_until_refused(store: StudyStore) -> None:
    while True:
        number = store.next_number()
        store.log("ask", number=number)
        store.write_trial(example_trial(number))


def log_until_refused(store: StudyStore) -> None:
    while True:  # the last block of the file may have room for some
        store.log("note", text="x" * 100)


def fill(path: Path) -> None:
    with path.open("wb", buffering=0) as ballast:
        while True:
            ballast.write(bytes(512))


def test_a_full_disk_refuses_the_next_trial_and_keeps_the_others(small_disk: Path) -> None:
    folder = small_disk / "a.study"
    store = StudyStore.create(folder, "")
    with pytest.raises(StoreError, match=r"cannot store trial \d+: the disk is full") as error:
        store_until_refused(store)
    assert "\n" not in str(error.value)
    stored = store.next_number() - 1
    assert stored > 5
    assert not list(folder.rglob(".*.tmp"))
    with StudyStore.open(folder) as reader:
        assert reader.numbers() == list(range(1, stored + 1))
        for trial in reader.trials():
            assert_same_trial(trial, example_trial(trial.number))
        assert [e["number"] for e in reader.events()] == list(range(1, stored + 2))

    with pytest.raises(OSError, match="No space"):
        fill(small_disk / "ballast")
    with pytest.raises(StoreError, match="cannot log 'note': the disk is full"):
        log_until_refused(store)
    assert store.damaged_event_lines() == [], "an event is refused whole"
    assert len(store.events()) > stored

    (small_disk / "ballast").unlink()
    store.write_trial(example_trial(stored + 1, rows=20))
    assert store.next_number() == stored + 2
    store.close()


def test_other_files_on_a_full_disk_are_not_left_half_written(
    small_disk: Path, tmp_path: Path
) -> None:
    with StudyStore.create(tmp_path / "a.study", "") as store:
        for number in range(1, 4):
            store.write_trial(example_trial(number, rows=40000))
    with pytest.raises(StoreError, match=r"p\.h5: cannot write the packed study: the disk is full"):
        pack_study(tmp_path / "a.study", small_disk / "p.h5")
    recording = example_trial(1, rows=40000).recording
    for ending in (".csv", ".h5"):
        path = small_disk / f"run{ending}"
        write_recording(example_trial(1, rows=10).recording, path)
        with pytest.raises(RecordingError, match="cannot be written: the disk is full"):
            write_recording(recording, path)
        assert len(read_recording(path)) == 10, "the older file is untouched"
    assert sorted(path.name for path in small_disk.iterdir()) == ["run.csv", "run.h5"]


def test_a_read_only_disk_is_readable_and_refuses_writers(small_disk: Path) -> None:
    folder = small_disk / "a.study"
    with StudyStore.create(folder, "") as store:
        store.write_trial(example_trial(1))
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    assert_same_trial(StudyStore.open(folder).read_trial(1), example_trial(1))
    with pytest.raises(StoreError, match="cannot open for writing: the file system is read-only"):
        StudyStore.open_for_writing(folder)
    with pytest.raises(StoreError, match="cannot make the study folder: the file system is read-"):
        StudyStore.create(small_disk / "b.study", "")
    with pytest.raises(RecordingError, match="cannot be written: the file system is read-only"):
        write_recording(example_trial(1).recording, small_disk / "run.csv")


LIMITED = """
import resource, signal, sys
from dataclasses import replace
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
sys.path.append({root!r})
from gmfbo.errors import StoreError
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.example_trials import assert_same_trial, example_trial
store = StudyStore.create(sys.argv[1], "")
store.write_trial(example_trial(1, rows=100))
resource.setrlimit(resource.RLIMIT_FSIZE, (40000, 40000))
try:
    store.write_trial(example_trial(2, rows=5000))
except StoreError as error:
    print(error)
store.write_trial(replace(example_trial(2, rows=100)))
assert_same_trial(store.trials()[0], example_trial(1, rows=100))
assert_same_trial(store.trials()[1], example_trial(2, rows=100))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of file size a process")
def test_a_file_that_stops_growing_half_way_is_removed(tmp_path: Path) -> None:
    """Needs no mount: the kernel refuses the write in its middle."""
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run(
        [sys.executable, "-c", LIMITED.format(root=str(root)), str(tmp_path / "a.study")],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "cannot store trial 2: the file is larger than this account may write" in done.stdout
    assert len(done.stdout.splitlines()) == 1
    assert sorted(p.name for p in (tmp_path / "a.study" / "trials").iterdir()) == [
        "000001.h5",
        "000002.h5",
    ]
