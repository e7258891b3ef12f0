"""Fill disks of random size under a writer, and limit its files; look at what is left."""

from __future__ import annotations

import random
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

from gmfbo.errors import StoreError
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.example_trials import assert_same_trial, example_trial

_ROOT = Path(__file__).resolve().parents[3]

_LIMITED = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
sys.path.append({root!r})
from pathlib import Path
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.full_disk_rounds import write_until_refused
store = StudyStore.create(sys.argv[1], "")
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
print(write_until_refused(store))
"""


@dataclass
class FullDiskReport:
    """What happened over all rounds.

    Attributes
    ----------
    disks, limits : int
        Writers that a full disk refused, and that a limit of file size refused.
    stored : int
        Trials whose write had returned.
    unclear : list of str
        Refusals that do not say what is the matter.
    lost : list of str
        Stored trials that are missing or different, and unfinished files that were left.
    """

    disks: int = 0
    limits: int = 0
    stored: int = 0
    unclear: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)


def run_full_disk_rounds(folder: Path, rounds: int, seed: int) -> FullDiskReport:
    """Let `rounds` writers meet a full disk (where mounting is permitted), as many a limit."""
    rng = random.Random(seed)
    report = FullDiskReport()
    folder.mkdir()
    for turn in range(rounds):
        disk = folder / str(turn)
        disk.mkdir()
        size = rng.randint(200, 2000)
        options = ["-t", "tmpfs", "-o", f"size={size}k", "tmpfs", str(disk)]
        if subprocess.run(["mount", *options], capture_output=True, check=False).returncode == 0:
            try:
                store = StudyStore.create(disk / "a.study", "")
                _look(disk / "a.study", write_until_refused(store), "the disk is full", report)
                store.close()
                report.disks += 1
            finally:
                subprocess.run(["umount", "-l", str(disk)], check=True)
        study, limit = folder / f"{turn}.study", rng.randint(20_000, 120_000)
        said = subprocess.run(
            [sys.executable, "-c", _LIMITED.format(root=str(_ROOT), limit=limit), str(study)],
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
        _look(study, said, "larger than this account may write", report)
        report.limits += 1
    return report


def write_until_refused(store: StudyStore) -> str:
    """Store trials of random length until the store refuses; returns what it said."""
    while True:
        number = store.next_number()
        try:
            store.log("ask", number=number)
            store.write_trial(example_trial(number))
        except StoreError as refused:
            return str(refused)


def _look(study: Path, said: str, expected: str, report: FullDiskReport) -> None:
    if expected not in said or "\n" in said:
        report.unclear.append(said)
    report.lost += [str(path) for path in study.rglob(".*.tmp")]
    with StudyStore.open(study) as store:
        asked = [event["number"] for event in store.events()]
        # All that was asked for before the last one was stored.
        if (
            store.numbers() != asked[: len(store.numbers())]
            or len(asked) > len(store.numbers()) + 1
        ):
            report.lost.append(f"{study}: asked {asked}, stored {store.numbers()}")
        for trial in store.trials():
            try:
                assert_same_trial(trial, example_trial(trial.number))
                report.stored += 1
            except AssertionError:
                report.lost.append(f"{study}: trial {trial.number} is another")
