"""Kill a writing process again and again, and look at what is left."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import h5py

from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.example_trials import assert_same_trial, example_trial

_ROOT = Path(__file__).resolve().parents[3]
_START = (
    "import runpy, sys; sys.path.append({root!r}); "
    "runpy.run_module({module!r}, run_name='__main__')"
)


@contextmanager
def writing_process(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Process that writes trials into a study folder; killed at the end."""
    program = _START.format(root=str(_ROOT), module="tests.recordings.store.killed_writer")
    with subprocess.Popen(
        [sys.executable, "-c", program, str(folder)], stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            yield process
        finally:
            process.kill()


@dataclass
class KillReport:
    """What happened over all rounds.

    Attributes
    ----------
    kills : int
        Processes killed.
    stored, asked : int
        Trials and events whose write had returned before the kill.
    unfinished_files : int
        Temporary files that a kill left and the next writer removed: kills during a write.
    torn_lines : int
        Event lines that a kill left unfinished.
    lost : list of str
        Whatever was acknowledged and is missing, damaged or different. Must be empty.
    """

    kills: int = 0
    stored: int = 0
    asked: int = 0
    unfinished_files: int = 0
    torn_lines: int = 0
    lost: list[str] = field(default_factory=list)


def run_kill_rounds(folder: Path, rounds: int, seed: int) -> KillReport:
    """Kill `rounds` writers at random moments of their work and check the study after each."""
    rng = random.Random(seed)
    StudyStore.create(folder, "name = 'killed'\n").close()
    report = KillReport()
    asked: set[int] = set()
    known: set[int] = set()
    for _ in range(rounds):
        with writing_process(folder) as process:
            assert process.stdout is not None
            # From within the first trial to some four trials later, at any point of a write.
            lines = [process.stdout.readline() for _ in range(rng.randint(1, 8))]
            time.sleep(rng.uniform(0.0, 0.015))
            assert process.poll() is None, "the writer ended by itself"
            process.kill()
            lines += process.stdout.readlines()
        report.kills += 1
        acknowledged = [line.split() for line in lines if line.endswith("\n")]
        asked |= {int(number) for word, number in acknowledged if word == "asked"}
        stored = {int(number) for word, number in acknowledged if word == "stored"}
        known |= _check_round(folder, stored, known, report)
    _check_study(folder, known, asked, report)
    report.stored, report.asked = len(known), len(asked)
    return report


def _check_round(folder: Path, stored: set[int], known: set[int], report: KillReport) -> set[int]:
    """Check what this round has added, as a reader finds it before any repair."""
    report.unfinished_files += len(list(folder.rglob(".*.tmp")))
    present = set(StudyStore.open(folder).numbers())
    report.lost += [f"trial {number}" for number in (stored | known) - present]
    for number in present - known:
        assert_same_trial(StudyStore.open(folder).read_trial(number), example_trial(number))
    with h5py.File(folder / "index.h5", "r") as index:
        assert all(index["trials"][name]["time"].size for name in list(index["trials"])[-3:])
    StudyStore.open_for_writing(folder).close()  # the lock died with its holder
    assert not list(folder.rglob(".*.tmp"))
    return present


def _check_study(folder: Path, known: set[int], asked: set[int], report: KillReport) -> None:
    with StudyStore.open(folder) as store:
        report.torn_lines = len(store.damaged_event_lines())
        logged = {event["number"] for event in store.events() if event["event"] == "ask"}
        report.lost += [f"event {number}" for number in asked - logged]
        for trial in store.trials():
            assert_same_trial(trial, example_trial(trial.number))
        assert store.numbers() == sorted(known) == list(range(1, len(known) + 1))
