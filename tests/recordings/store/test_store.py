"""A study on disk: trials, events, index, and who may write."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gmfbo.errors import StoreError
from gmfbo.recordings import Recording
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.example_trials import PROVENANCE, assert_same_trial, example_trial

STUDY = 'name = "axis 3"\nseed = 0  # Δ\r\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Study of five trials and two events."""
    folder = tmp_path / "axis3.study"
    with StudyStore.create(folder, STUDY) as store:
        for number in range(1, 6):
            store.write_trial(example_trial(number))
        store.log("ask", number=1, gains={"ctl.Kp": np.float64(90.0)})
        store.log("tell", number=1, path=Path("a/b"), values=np.array([1, 2]), kinds={"b", "a"})
    return folder


def test_a_study_folder_holds_what_its_format_says(folder: Path) -> None:
    assert sorted(path.name for path in folder.iterdir()) == [
        "events.jsonl",
        "index.h5",
        "study.toml",
        "trials",
        "writer.lock",
    ]
    names = sorted(path.name for path in (folder / "trials").iterdir())
    assert names == [f"00000{n}.h5" for n in range(1, 6)]
    assert (folder / "study.toml").read_bytes().decode() == STUDY


def test_what_is_stored_is_read_bit_by_bit(folder: Path) -> None:
    with StudyStore.open(folder) as store:
        assert store.study_text == STUDY
        assert store.next_number() == 6
        assert [trial.number for trial in store.trials()] == [1, 2, 3, 4, 5]
        for trial in store.trials():
            assert_same_trial(trial, example_trial(trial.number))
        assert_same_trial(store.read_trial(3), example_trial(3))


@given(
    gains=st.dictionaries(st.text(min_size=1, max_size=8).filter(lambda t: "\0" not in t),
                          st.floats(allow_nan=False), max_size=4),
    objective=st.floats(),
    sigma_c=st.none() | st.floats(0.0, 1.0),
    accepted=st.none() | st.booleans(),
    parent=st.none() | st.integers(1, 10**6),
    status=st.sampled_from(["ok", "diverged", "unsafe"]),
)  # fmt: skip
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_provenance_comes_back(
    tmp_path_factory: pytest.TempPathFactory,
    gains: dict[str, float],
    objective: float,
    sigma_c: float | None,
    accepted: bool | None,
    parent: int | None,
    status: str,
) -> None:
    trial = replace(
        example_trial(1, rows=3),
        gains=gains,
        objective=objective,
        sigma_c=sigma_c,
        accepted=accepted,
        parent=parent,
        status=status,
        recording=Recording(time=np.arange(3.0), signals={"x": np.array([1.0, np.nan, np.inf])}),
    )
    with StudyStore.create(tmp_path_factory.mktemp("s") / "a.study", "") as store:
        store.write_trial(trial)
        got = store.read_trial(1)
    assert got.gains == gains
    assert list(got.gains) == list(gains)
    np.testing.assert_equal(got.objective, objective)
    assert (got.sigma_c, got.accepted, got.parent) == (sigma_c, accepted, parent)
    assert type(got.recording) is Recording
    np.testing.assert_array_equal(got.recording.signal("x"), [1.0, np.nan, np.inf])


def test_plain_h5py_finds_every_attribute_of_the_format(folder: Path) -> None:
    with h5py.File(folder / "trials" / "000003.h5") as file:
        attributes = dict(file.attrs)
        assert attributes["source"] == "IS3"
        assert list(attributes["gain_names"]) == ["ctl.Kp", "ctl.Kd"]
        assert attributes["gains"][0] == 33.0
        assert attributes["metric.overshoot"] == 3.25
        for name in {*PROVENANCE} - {"metrics", "versions"}:
            assert name in attributes
        assert attributes["version.gmfbo"] == "0.1.0"
        assert file["position"].attrs["unit"] == "rad"
        for name in ("time", "position_uncorrected", "position_std"):
            assert file[name].shape == file["position"].shape


def test_versions_are_those_of_the_software_that_ran(tmp_path: Path) -> None:
    with StudyStore.create(tmp_path / "a.study", "") as store:
        store.write_trial(replace(example_trial(1), versions={}))
        versions = store.read_trial(1).versions
    assert versions["numpy"] == np.__version__
    assert {"python", "gmfbo", "h5py", "torch"} <= set(versions)


def test_the_index_shows_the_study_as_one_file(folder: Path) -> None:
    with h5py.File(folder / "index.h5") as index:
        assert list(index["trials"]) == [f"00000{n}" for n in range(1, 6)]
        assert isinstance(index["trials"].get("000001", getlink=True), h5py.ExternalLink)
        expected = example_trial(2).recording.signal("position")
        np.testing.assert_array_equal(index["trials/000002/position"], expected)
        assert index.attrs["study"] == STUDY


def test_the_index_is_derived_and_comes_back(folder: Path) -> None:
    before = (folder / "index.h5").read_bytes()
    (folder / "index.h5").write_bytes(b"damaged")
    assert len(StudyStore.open(folder).trials()) == 5
    StudyStore.open_for_writing(folder).close()
    assert (folder / "index.h5").read_bytes() == before


def test_a_moved_study_is_whole(folder: Path) -> None:
    moved = folder.rename(folder.parent / "elsewhere.study")
    with h5py.File(moved / "index.h5") as index:
        assert index["trials/000005"].attrs["number"] == 5


def test_a_trial_is_written_once(folder: Path) -> None:
    with StudyStore.open_for_writing(folder) as store:
        with pytest.raises(StoreError, match="trial 5 is stored already"):
            store.write_trial(example_trial(5))
        with pytest.raises(StoreError, match="at least 1, got 0"):
            store.write_trial(replace(example_trial(1), number=0))
        assert store.write_trial(example_trial(6)).name == "000006.h5"


def test_one_process_has_one_writer(folder: Path) -> None:
    with StudyStore.open_for_writing(folder):
        with pytest.raises(StoreError, match="this process is writing this study; wait"):
            StudyStore.open_for_writing(folder)
        assert len(StudyStore.open(folder).trials()) == 5
    StudyStore.open_for_writing(folder).close()


def test_a_reader_cannot_write(folder: Path) -> None:
    with StudyStore.open(folder) as store:
        for write in (lambda: store.write_trial(example_trial(6)), lambda: store.log("x")):
            with pytest.raises(StoreError, match="open for reading only"):
                write()
        with pytest.raises(StoreError, match="open for reading only"):
            store.refresh_index()


def test_a_closed_writer_cannot_write(folder: Path) -> None:
    store = StudyStore.open_for_writing(folder)
    store.close()
    store.close()
    with pytest.raises(StoreError, match="open for reading only"):
        store.write_trial(example_trial(6))


def test_the_next_writer_clears_unfinished_files_away(folder: Path) -> None:
    (folder / "trials" / ".000006.h5.4711.tmp").write_bytes(b"half")
    (folder / ".index.h5.4711.tmp").write_bytes(b"half")
    assert len(StudyStore.open(folder).trials()) == 5
    StudyStore.open_for_writing(folder).close()
    assert not list(folder.rglob(".*.tmp"))
    repair = StudyStore.open(folder).events()[-1]
    assert repair["event"] == "repair"
    assert repair["unfinished_files"] == [".index.h5.4711.tmp", ".000006.h5.4711.tmp"]


def test_creating_over_a_study_or_other_files_is_refused(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="holds a study already; resume it"):
        StudyStore.create(folder, STUDY)
    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.tex").touch()
    with pytest.raises(StoreError, match="expected a new or empty folder"):
        StudyStore.create(other, STUDY)
    with pytest.raises(StoreError, match="cannot make the study folder: the folder does not exist"):
        StudyStore.create(tmp_path / "no" / "a.study", STUDY)


def test_a_killed_creation_can_be_repeated(tmp_path: Path) -> None:
    folder = tmp_path / "a.study"
    (folder / "trials").mkdir(parents=True)
    (folder / "writer.lock").touch()
    (folder / ".study.toml.4711.tmp").touch()
    StudyStore.create(folder, STUDY).close()
    assert StudyStore.open(folder).study_text == STUDY


def test_what_is_no_study_is_not_opened(tmp_path: Path, folder: Path) -> None:
    for opener in (StudyStore.open, StudyStore.open_for_writing):
        with pytest.raises(StoreError, match=r"expected a study folder.*, but there is none"):
            opener(tmp_path / "none.study")
        with pytest.raises(StoreError, match=r"holds no study\.toml"):
            opener(tmp_path)
    with pytest.raises(StoreError, match="no readable HDF5 file"):
        StudyStore.open(folder / "study.toml")
    with pytest.raises(StoreError, match="this HDF5 file is neither"):
        StudyStore.open(folder / "index.h5")


def test_a_missing_or_damaged_trial_is_named(folder: Path) -> None:
    path = folder / "trials" / "000004.h5"
    path.write_bytes(path.read_bytes()[:2000])
    with StudyStore.open(folder) as store:
        with pytest.raises(StoreError, match=r"000004\.h5: expected a whole trial file"):
            store.trials()
        with pytest.raises(StoreError, match="no trial 9; there are 1 to 5"):
            store.read_trial(9)
        assert store.read_trial(5).number == 5


def test_events_come_back_in_order_with_their_values(folder: Path) -> None:
    events = StudyStore.open(folder).events()
    assert [event["event"] for event in events] == ["ask", "tell"]
    assert events[0]["gains"] == {"ctl.Kp": 90.0}
    assert (events[1]["path"], events[1]["values"]) == ("a/b", [1, 2])
    assert events[1]["kinds"] == ["a", "b"]
    # Each line is plain JSON for others.
    lines = (folder / "events.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["event"] for line in lines] == ["ask", "tell"]


@pytest.mark.parametrize("keep", [1, 20, -2])
def test_a_torn_last_line_is_reported_and_the_next_event_stands(folder: Path, keep: int) -> None:
    path = folder / "events.jsonl"
    first, second = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(first + second[:keep])
    assert StudyStore.open(folder).damaged_event_lines() == [2]
    with StudyStore.open_for_writing(folder) as store:
        store.log("resume", number=2)
        assert [event["event"] for event in store.events()] == ["ask", "repair", "resume"]
        assert store.events()[1]["damaged_lines"] == [2]
        assert store.damaged_event_lines() == [2]
    StudyStore.open_for_writing(folder).close()
    assert len(StudyStore.open(folder).events()) == 3, "a damaged line is told once"


def test_a_changed_event_fails_its_checksum(folder: Path) -> None:
    path = folder / "events.jsonl"
    path.write_bytes(path.read_bytes().replace(b"90.0", b"91.0"))
    with StudyStore.open(folder) as store:
        assert [event["event"] for event in store.events()] == ["tell"]
        assert store.damaged_event_lines() == [1]


@given(
    fields=st.dictionaries(
        st.text(max_size=6).filter(lambda t: t not in ("event", "time", "crc32")),
        st.one_of(st.text(max_size=20), st.integers(), st.floats(allow_nan=False), st.none()),
        max_size=4,
    )
)
def test_any_text_in_an_event_keeps_to_its_line(
    tmp_path_factory: pytest.TempPathFactory, fields: dict[str, object]
) -> None:
    with StudyStore.create(tmp_path_factory.mktemp("s") / "a.study", "") as store:
        for _ in range(2):
            store.log("note", **fields)
        assert store.damaged_event_lines() == []
        for event in store.events():
            assert {name: event[name] for name in fields} == fields


@pytest.mark.parametrize("code", [13, 30, 28, 122])
def test_a_refusal_of_the_operating_system_is_one_clear_line(
    folder: Path, monkeypatch: pytest.MonkeyPatch, code: int
) -> None:
    """At the operating system's border: no rights, read-only, full, over quota."""
    meanings = {13: "no permission", 30: "read-only", 28: "disk is full", 122: "quota is used up"}
    real_open = os.open

    def refuse(path: str, flags: int, *args: int) -> int:
        if flags & os.O_CREAT:
            raise OSError(code, os.strerror(code), str(path))
        return real_open(path, flags, *args)

    store = StudyStore.open_for_writing(folder)
    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(StoreError, match=f"cannot store trial 6: .*{meanings[code]}") as error:
        store.write_trial(example_trial(6))
    assert "\n" not in str(error.value)
    with pytest.raises(StoreError, match=f"cannot log 'ask': .*{meanings[code]}"):
        store.log("ask")
    with pytest.raises(StoreError, match=f"cannot write the index: .*{meanings[code]}"):
        store.refresh_index()
    store.close()
    with pytest.raises(StoreError, match=f"cannot open for writing: .*{meanings[code]}"):
        StudyStore.open_for_writing(folder)
    with pytest.raises(StoreError, match=f"cannot make the study folder: .*{meanings[code]}"):
        StudyStore.create(folder.parent / "new.study", "")
    monkeypatch.undo()
    assert len(StudyStore.open(folder).trials()) == 5
