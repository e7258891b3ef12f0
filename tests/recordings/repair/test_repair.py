"""`gmfbo repair`: what is damaged is mended or set aside, and the study goes on."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from gmfbo.cli import main
from gmfbo.errors import StoreError
from gmfbo.recordings import Recording
from gmfbo.recordings.repair.repair_folder import repair_folder
from gmfbo.recordings.repair.repair_packed import repair_packed
from gmfbo.recordings.store.pack import pack_study
from gmfbo.recordings.store.seal import without_seal
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.repair.damage_rounds import STUDY, run_damage_rounds
from tests.recordings.store.example_trials import assert_same_trial, example_trial


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Study of four trials and four events."""
    folder = tmp_path / "a.study"
    with StudyStore.create(folder, STUDY) as store:
        for number in range(1, 5):
            store.log("ask", number=number)
            store.write_trial(example_trial(number, rows=300))
    return folder


def fill(path: Path) -> None:
    with path.open("wb", buffering=0) as ballast:
        while True:
            ballast.write(bytes(512))


def trial_file(folder: Path, number: int) -> Path:
    return folder / "trials" / f"{number:06d}.h5"


def turn_bit(path: Path, byte: int) -> None:
    content = bytearray(path.read_bytes())
    content[byte] ^= 4
    path.write_bytes(content)


def test_ten_damaged_studies_lose_only_what_was_damaged_beyond_one_bit(tmp_path: Path) -> None:
    report = run_damage_rounds(tmp_path, rounds=10, seed=3)
    assert report.wrong == []
    assert report.mended["one bit"] == report.damaged["one bit"] > 0
    assert sum(report.lost.values()) > 0
    assert report.lines_mended == report.lines > 0


def test_a_whole_study_is_left_as_it_is(folder: Path) -> None:
    before = {p: p.read_bytes() for p in folder.rglob("*") if p.is_file() and p.suffix != ".lock"}
    report = repair_folder(folder)
    assert (report.whole, report.mended, report.lost, report.lines) == ([1, 2, 3, 4], [], [], [])
    after = {p: p.read_bytes() for p in folder.rglob("*") if p.is_file() and p.suffix != ".lock"}
    assert after == before


def test_a_turned_bit_is_refused_by_readers_and_mended(folder: Path) -> None:
    path = trial_file(folder, 2)
    before = path.read_bytes()
    turn_bit(path, 9000)  # a sample: plain HDF5 would read another number
    with pytest.raises(StoreError, match=r"damaged .its content is not what.*run `gmfbo rep"):
        StudyStore.open(folder).read_trial(2)
    report = repair_folder(folder)
    assert (report.mended, report.lost) == ([2], [])
    assert path.read_bytes() == before
    assert (folder / "damaged" / "000002.h5").read_bytes() != before
    assert StudyStore.open(folder).events()[-1]["mended_trials"] == [2]


def test_what_is_left_of_a_cut_off_trial_is_saved_as_a_recording(folder: Path) -> None:
    path = trial_file(folder, 3)
    whole = example_trial(3, rows=300).recording
    path.write_bytes(path.read_bytes()[:-6000])
    report = repair_folder(folder)
    assert report.lost == [3]
    saved = Recording.read(folder / "damaged" / "000003.saved.h5")
    np.testing.assert_array_equal(saved.time, whole.time)
    assert 0 < len(saved.signals) < 6
    for name, values in saved.signals.items():
        original = example_trial(3, rows=300)
        expected = {
            **original.recording.signals,
            **original.recording.schedules,
            **{f"{n}_uncorrected": v for n, v in original.uncorrected.items()},
            **{f"{n}_std": v for n, v in original.std.items()},
        }[name]
        np.testing.assert_array_equal(values, expected)
    assert saved.parameters["ctl.Kp"] == 33.0
    assert StudyStore.open(folder).numbers() == [1, 2, 4]


def test_signals_are_saved_up_to_a_damaged_time(folder: Path) -> None:
    path = trial_file(folder, 1)
    with h5py.File(path, "r+") as file:
        file["time"][200] = 17.0
        file["position"][3] = 1e9  # what else is wrong nobody can know
    assert repair_folder(folder).lost == [1]
    saved = Recording.read(folder / "damaged" / "000001.saved.h5")
    np.testing.assert_array_equal(saved.time, example_trial(1, rows=300).recording.time[:200])
    assert saved.signal("position")[3] == 1e9


def test_a_study_without_seals_is_read_and_a_damaged_one_of_them_is_set_aside(
    folder: Path,
) -> None:
    """Trial files of an early version; damage may crash HDF5, so another process goes first."""
    for number in range(1, 5):
        path = trial_file(folder, number)
        path.write_bytes(without_seal(path.read_bytes()))
    for trial in StudyStore.open(folder).trials():
        assert_same_trial(trial, example_trial(trial.number, rows=300))
    path = trial_file(folder, 1)
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(StoreError, match=r"000001\.h5: expected a whole trial file"):
        StudyStore.open(folder).read_trial(1)
    assert repair_folder(folder).lost == [1]
    assert len(StudyStore.open(folder).trials()) == 3


def test_a_lost_study_file_comes_back_from_the_index(folder: Path) -> None:
    (folder / "study.toml").write_bytes(b"name = \xff")
    with pytest.raises(StoreError, match=r"study\.toml: expected UTF-8 text, but it is damaged"):
        _ = StudyStore.open(folder).study_text
    report = repair_folder(folder)
    assert "brought back from index.h5" in report.lines[0]
    assert StudyStore.open(folder).study_text == STUDY
    (folder / "study.toml").unlink()
    repair_folder(folder)
    assert StudyStore.open(folder).study_text == STUDY


def test_an_edited_study_file_stays_and_the_copy_is_shown(folder: Path) -> None:
    edited = STUDY + "# mine\n"
    (folder / "study.toml").write_text(edited, encoding="utf-8")
    (line,) = repair_folder(folder).lines
    assert "differs from the copy in index.h5" in line
    assert StudyStore.open(folder).study_text == edited
    assert (folder / "damaged" / "study.toml.from-index").read_text(encoding="utf-8") == STUDY


def test_without_a_study_file_and_its_copy_the_repair_says_what_is_needed(folder: Path) -> None:
    (folder / "study.toml").unlink()
    (folder / "index.h5").unlink()
    with pytest.raises(StoreError, match=r"missing, and .* no copy; put .*: 4 trial files are wa"):
        repair_folder(folder)
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    assert repair_folder(folder).whole == [1, 2, 3, 4]


def test_damaged_event_lines_are_mended_or_named(folder: Path) -> None:
    path = folder / "events.jsonl"
    before = path.read_bytes()
    turn_bit(path, 30)
    assert "one bit had turned in line 1; mended" in repair_folder(folder).lines[0]
    assert path.read_bytes().startswith(before)
    lines = before.split(b"\n")
    lines[1] = lines[1][:20]
    path.write_bytes(b"\n".join(lines))
    assert repair_folder(folder).lines == ["events.jsonl: line 2 damaged; passed over from now on"]
    assert [e["number"] for e in StudyStore.open(folder).events() if "number" in e] == [1, 3, 4]


def test_a_study_that_is_written_is_not_repaired(folder: Path) -> None:
    with (
        StudyStore.open_for_writing(folder),
        pytest.raises(StoreError, match="is writing this study; wait for it to end"),
    ):
        repair_folder(folder)


def test_a_read_only_study_is_refused_with_what_is_whole(small_disk: Path, folder: Path) -> None:
    copy = small_disk / "a.study"
    shutil.copytree(folder, copy)
    turn_bit(trial_file(copy, 4), 9000)
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    with pytest.raises(
        StoreError,
        match=r"cannot repair: the file system is read-only.*; 3 trials are whole, damaged are 4; "
        "repair a copy of the folder",
    ):
        repair_folder(copy)


def test_a_full_disk_stops_a_repair_that_can_be_repeated(small_disk: Path, folder: Path) -> None:
    copy = small_disk / "a.study"
    shutil.copytree(folder, copy)
    turn_bit(trial_file(copy, 4), 9000)
    with pytest.raises(OSError, match="No space"):
        fill(small_disk / "ballast")
    with pytest.raises(StoreError, match=r"stopped half way: the disk is full; .*repeat"):
        repair_folder(copy)
    (small_disk / "ballast").unlink()
    assert repair_folder(copy).mended == [4]
    for trial in StudyStore.open(copy).trials():
        assert_same_trial(trial, example_trial(trial.number, rows=300))


_REPAIRING = """
import sys
from gmfbo.recordings.repair.repair_folder import repair_folder
print("begins", flush=True)
print(repair_folder(sys.argv[1]), flush=True)
"""


def test_a_killed_repair_is_repeated(folder: Path, tmp_path: Path) -> None:
    turn_bit(trial_file(folder, 1), 9000)
    trial_file(folder, 3).write_bytes(trial_file(folder, 3).read_bytes()[:-6000])
    turn_bit(folder / "events.jsonl", 30)
    for turn, delay in enumerate([0.0, 0.005, 0.01, 0.02, 0.05]):
        copy = tmp_path / f"{turn}.study"
        shutil.copytree(folder, copy)
        with subprocess.Popen(
            [sys.executable, "-c", _REPAIRING, str(copy)], stdout=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            process.stdout.readline()
            time.sleep(delay)
            process.kill()
        repair_folder(copy)
        assert repair_folder(copy).lines == []
        with StudyStore.open(copy) as store:
            assert store.numbers() == [1, 2, 4]
            assert store.damaged_event_lines() == []
            for trial in store.trials():
                assert_same_trial(trial, example_trial(trial.number, rows=300))
        assert list((copy / "damaged").glob("000003*.h5"))


@pytest.mark.parametrize("name", ["none.study", "empty", "file.txt"])
def test_what_is_no_study_is_refused(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "file.txt").write_text("x", encoding="utf-8")
    assert main(["repair", str(tmp_path / name)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "expected a study folder or a packed study" in said


def test_a_repaired_study_prints_what_was_done(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    turn_bit(trial_file(folder, 1), 9000)
    trial_file(folder, 2).write_bytes(b"")
    assert main(["repair", str(folder)]) == 0
    first, second, last = capsys.readouterr().out.splitlines()
    assert "trial 1: one bit of byte 9000 had turned; mended to the byte" in first
    assert "trial 2: " in second
    assert "nothing of it can be saved" in second
    assert last == f"{folder}: 2 trials whole, 1 mended, 1 lost (2)"
    assert main(["repair", str(folder)]) == 0
    assert capsys.readouterr().out == f"{folder}: 3 trials whole; nothing is damaged\n"


@pytest.fixture
def packed(folder: Path, tmp_path: Path) -> Path:
    return pack_study(folder, tmp_path / "a.h5")


def test_a_turned_bit_of_a_packed_study_is_mended_beside_it(packed: Path) -> None:
    before = packed.read_bytes()
    turn_bit(packed, len(before) // 2)
    with pytest.raises(StoreError, match=r"damaged .*checksum.*; run `gmfbo repair .*a\.h5`"):
        StudyStore.open(packed)
    report = repair_packed(packed)
    assert report.location == packed.with_name("a.repaired.h5")
    assert report.location.read_bytes() == before
    with pytest.raises(StoreError, match="is there already, from an earlier repair"):
        repair_packed(packed)


def cut_off(content: bytes) -> bytes:
    return content[: int(0.8 * len(content))]


def overwritten(content: bytes) -> bytes:
    middle = len(content) // 2
    return content[:middle] + bytes(1000) + content[middle + 1000 :]


@pytest.mark.parametrize("harm", [cut_off, overwritten])
def test_the_whole_trials_of_a_damaged_packed_study_become_a_folder(
    packed: Path, harm: Callable[[bytes], bytes]
) -> None:
    packed.write_bytes(harm(packed.read_bytes()))
    report = repair_packed(packed)
    assert 0 < len(report.whole) < 4
    assert sorted(report.whole + report.lost) == [1, 2, 3, 4]
    with StudyStore.open(report.location) as store:
        assert store.study_text == STUDY
        for trial in store.trials():
            assert_same_trial(trial, example_trial(trial.number, rows=300))


def test_a_packed_study_of_which_nothing_is_left_is_refused(packed: Path) -> None:
    packed.write_bytes(packed.read_bytes()[:3000])
    with pytest.raises(StoreError, match="nothing can be saved of it"):
        repair_packed(packed)
    assert sorted(p.name for p in packed.parent.glob("*a*")) == ["a.h5", "a.study"]
