"""A study in memory keeps what a study on disk keeps, and becomes one file like it."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import StoreError
from gmfbo.recordings.store.memory_store import MemoryStore, TrialStore
from gmfbo.recordings.store.pack import pack_record, pack_study
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.example_trials import PROVENANCE, example_trial

TEXT = 'name = "some"\n'
MAKERS: dict[str, Callable[[Path], TrialStore]] = {
    "folder": lambda path: StudyStore.create(path, TEXT),
    "memory": lambda path: MemoryStore(path, TEXT),
}


@pytest.fixture(params=MAKERS)
def store(request: pytest.FixtureRequest, tmp_path: Path) -> TrialStore:
    """One of each kind, empty."""
    return MAKERS[request.param](tmp_path / "some.study")


def test_trials_come_back_in_order_with_the_versions_that_made_them(store: TrialStore) -> None:
    for number in (1, 2, 3):
        store.write_trial(example_trial(number))
    store.refresh_index()
    for number, read in enumerate(store.trials(), start=1):
        given = example_trial(number)
        for name in PROVENANCE:
            if name != "versions" or given.versions:
                assert getattr(read, name) == getattr(given, name)
        assert read.versions["gmfbo"]
        for name, column in given.recording.signals.items():
            np.testing.assert_array_equal(read.recording.signal(name), column)


def test_number_is_taken_once(store: TrialStore) -> None:
    store.write_trial(example_trial(1))
    with pytest.raises(StoreError, match="trial 1 is stored already"):
        store.write_trial(example_trial(1))
    assert len(store.trials()) == 1


def test_number_below_one_is_refused(store: TrialStore) -> None:
    with pytest.raises(StoreError, match="expected a trial number of at least 1, got 0"):
        store.write_trial(example_trial(0))


def test_events_come_back_as_json_holds_them(store: TrialStore) -> None:
    store.log("ask", number=np.int64(3), gains={"ctl.Kp": np.float64(0.1)}, points=np.arange(2.0))
    store.log("tell", number=3)
    asked, told = store.events()
    assert (asked["event"], told["event"]) == ("ask", "tell")
    assert asked["gains"] == {"ctl.Kp": 0.1}
    assert asked["points"] == [0.0, 1.0]


def test_record_packs_to_what_the_folder_packs_to(tmp_path: Path) -> None:
    stores = {name: make(tmp_path / f"{name}.study") for name, make in MAKERS.items()}
    for one in stores.values():
        for number in (1, 2, 3):
            one.write_trial(example_trial(number))
        one.log("tell", number=3)
    memory = stores["memory"]
    assert isinstance(memory, MemoryStore)
    record = pickle.loads(pickle.dumps(memory.record))  # it travels between processes
    with (
        StudyStore.open(pack_study(stores["folder"].location, tmp_path / "a.h5")) as folder,
        StudyStore.open(pack_record(record, tmp_path / "b.h5")) as packed,
    ):
        assert packed.study_text == folder.study_text == TEXT
        assert [event["event"] for event in packed.events()] == ["tell"]
        for trial, other in zip(folder.trials(), packed.trials(), strict=True):
            for name in PROVENANCE:
                assert getattr(trial, name) == getattr(other, name)
            for name, column in trial.recording.signals.items():
                np.testing.assert_array_equal(column, other.recording.signal(name))
            for name, column in trial.std.items():
                np.testing.assert_array_equal(column, other.std[name])
