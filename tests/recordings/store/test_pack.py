"""A packed study holds what the folder holds."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from gmfbo.errors import StoreError
from gmfbo.recordings.store.pack import pack_study
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.example_trials import assert_same_trial, example_trial


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "a.study"
    with StudyStore.create(folder, "name = 'Δ'\n") as store:
        for number in range(1, 5):
            store.write_trial(example_trial(number))
        store.log("ask", number=5)
    return folder


def test_a_packed_study_reads_like_its_folder(folder: Path, tmp_path: Path) -> None:
    path = pack_study(folder, tmp_path / "a.h5")
    with StudyStore.open(folder) as one, StudyStore.open(path) as other:
        assert other.study_text == one.study_text
        assert other.events() == one.events()
        assert other.numbers() == one.numbers() == [1, 2, 3, 4]
        assert other.next_number() == 5
        for trial in other.trials():
            assert_same_trial(trial, example_trial(trial.number))
        assert_same_trial(other.read_trial(3), example_trial(3))


def test_a_packed_study_stands_on_its_own_in_plain_h5py(folder: Path, tmp_path: Path) -> None:
    path = pack_study(folder, tmp_path / "a.h5")
    folder.rename(tmp_path / "gone")
    with h5py.File(path) as file, h5py.File(tmp_path / "gone" / "index.h5") as index:
        for name in file["trials"]:
            packed, indexed = file["trials"][name], index["trials"][name]
            assert set(packed) == set(indexed)
            assert set(packed.attrs) == set(indexed.attrs)
            for signal in packed:
                np.testing.assert_array_equal(packed[signal][()], indexed[signal][()])
                assert packed[signal].attrs["kind"] == indexed[signal].attrs["kind"]


def test_a_study_is_packed_while_it_is_written(folder: Path, tmp_path: Path) -> None:
    with StudyStore.open_for_writing(folder) as store:
        store.write_trial(example_trial(5))
        path = pack_study(folder, tmp_path / "a.h5")
        store.write_trial(example_trial(6))
    assert StudyStore.open(path).numbers() == [1, 2, 3, 4, 5]


def test_a_study_without_trials_or_events_is_packed(tmp_path: Path) -> None:
    StudyStore.create(tmp_path / "b.study", "").close()
    path = pack_study(tmp_path / "b.study", tmp_path / "b.h5")
    with StudyStore.open(path) as store:
        assert (store.trials(), store.events(), store.study_text) == ([], [], "")


def test_a_packed_study_is_for_reading(folder: Path, tmp_path: Path) -> None:
    path = pack_study(folder, tmp_path / "a.h5")
    with pytest.raises(StoreError, match="can only be read; name the study folder"):
        StudyStore.open_for_writing(path)
    with pytest.raises(StoreError, match="open for reading only"):
        StudyStore.open(path).write_trial(example_trial(9))
    with pytest.raises(StoreError, match="no trial 9; there are 1 to 4"):
        StudyStore.open(path).read_trial(9)


def test_what_cannot_be_packed_is_said(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(StoreError, match=r"ends in \.h5, got '\.zip'"):
        pack_study(folder, tmp_path / "a.zip")
    with pytest.raises(StoreError, match="expected a study folder"):
        pack_study(tmp_path / "none", tmp_path / "a.h5")
    with pytest.raises(StoreError, match="the folder does not exist"):
        pack_study(folder, tmp_path / "none" / "a.h5")
    damaged = folder / "trials" / "000002.h5"
    damaged.write_bytes(damaged.read_bytes()[:1000])
    with pytest.raises(StoreError, match=r"000002\.h5: expected a whole trial file"):
        pack_study(folder, tmp_path / "a.h5")
    assert not list(tmp_path.glob("*.h5"))
