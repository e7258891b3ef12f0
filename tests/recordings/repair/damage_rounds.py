"""Damage files of a study at random, read it, repair it, and look at what is left."""

from __future__ import annotations

import random
import shutil
from dataclasses import dataclass, field
from pathlib import Path

from gmfbo.errors import GmfboError, StoreError
from gmfbo.recordings.recording import read_recording
from gmfbo.recordings.repair.repair_folder import repair_folder
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.recordings.store.trial import Trial
from tests.recordings.store.example_trials import assert_same_trial, example_trial

KINDS = (
    "one bit",
    "bits",
    "block of zeros",
    "block of noise",
    "end of zeros",
    "cut off",
    "emptied",
)
STUDY = 'name = "damaged"\n[is1]\ntwin = "axis.toml"\n'


@dataclass
class DamageReport:
    """What happened over all rounds.

    Attributes
    ----------
    rounds : int
        Studies damaged and repaired.
    damaged, mended, lost : dict of str to int
        Files of trials by kind of damage: all, read as they were written after the repair (mended
        to the byte, or damaged where nothing is held), set aside.
    saved : int
        Of those set aside, how many gave at least one signal.
    lines, lines_mended : int
        Event lines damaged, and brought back to the byte.
    wrong : list of str
        Whatever was read differently from what was written, or lost without being damaged.
    """

    rounds: int = 0
    damaged: dict[str, int] = field(default_factory=lambda: dict.fromkeys(KINDS, 0))
    mended: dict[str, int] = field(default_factory=lambda: dict.fromkeys(KINDS, 0))
    lost: dict[str, int] = field(default_factory=lambda: dict.fromkeys(KINDS, 0))
    saved: int = 0
    lines: int = 0
    lines_mended: int = 0
    wrong: list[str] = field(default_factory=list)


def damage(content: bytes, kind: str, rng: random.Random) -> bytes:
    """Content with one damage of a kind; it always differs from what was given."""
    changed = bytearray(content)
    if kind == "one bit":
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    elif kind == "bits":
        for place in rng.sample(range(len(changed)), rng.randint(2, 40)):
            changed[place] ^= 1 << rng.randrange(8)
    elif kind.startswith("block"):
        size = min(rng.choice([16, 512, 4096]), len(changed))
        begin = rng.randrange(len(changed) - size + 1)
        block = bytes(size) if kind.endswith("zeros") else rng.randbytes(size)
        changed[begin : begin + size] = block
    elif kind == "end of zeros":  # as a file system leaves a file after a power cut
        size = rng.randint(1, 5000)
        changed[-size:] = bytes(min(size, len(changed)))
    elif kind == "cut off":
        del changed[rng.randrange(1, len(changed)) :]
    else:
        changed.clear()
    return bytes(changed)


def run_damage_rounds(folder: Path, rounds: int, seed: int) -> DamageReport:
    """Damage `rounds` copies of a study of six trials, one to three files each."""
    rng = random.Random(seed)
    whole = folder / "whole.study"
    with StudyStore.create(whole, STUDY) as store:
        for number in range(1, 7):
            store.log("ask", number=number)
            store.write_trial(example_trial(number, rows=rng.randint(20, 400)))
        trials = {trial.number: trial for trial in store.trials()}
    report = DamageReport()
    for turn in range(rounds):
        copy = folder / f"{turn}.study"
        shutil.copytree(whole, copy)
        _round(whole, copy, trials, rng, report)
        shutil.rmtree(copy)
        report.rounds += 1
    return report


def _round(
    whole: Path, copy: Path, trials: dict[int, Trial], rng: random.Random, report: DamageReport
) -> None:
    kinds = {number: rng.choice(KINDS) for number in rng.sample(list(trials), rng.randint(1, 3))}
    for number, kind in kinds.items():
        _damage_file(copy / "trials" / f"{number:06d}.h5", kind, rng)
        report.damaged[kind] += 1
    lines = _damage_events(copy, rng, report)
    if rng.random() < 0.3:
        _damage_file(copy / "index.h5", rng.choice(KINDS), rng)
    elif rng.random() < 0.3:
        (copy / "study.toml").unlink()  # the index has a copy
    _read_as_found(copy, trials, report)
    found = repair_folder(copy)
    _look_at_trials(copy, kinds, trials, report)
    if lines and (copy / "events.jsonl").read_bytes().startswith(
        (whole / "events.jsonl").read_bytes()
    ):
        report.lines_mended += 1
    for number in found.lost:
        if number not in kinds:
            report.wrong.append(f"trial {number} was whole and is lost")
        if list((copy / "damaged").glob(f"{number:06d}.saved.h5")):
            try:
                read_recording(copy / "damaged" / f"{number:06d}.saved.h5")
                report.saved += 1
            except GmfboError as refused:
                report.wrong.append(f"what was saved is no recording: {refused}")
    if (copy / "study.toml").read_bytes() != (whole / "study.toml").read_bytes():
        report.wrong.append("study.toml")
    if repair_folder(copy).lost:
        report.wrong.append("a repaired study is damaged")


def _damage_file(path: Path, kind: str, rng: random.Random) -> None:
    before = path.read_bytes()
    after = before
    while after == before:  # a block of zeros may fall on zeros
        after = damage(before, kind, rng)
    path.write_bytes(after)


def _damage_events(copy: Path, rng: random.Random, report: DamageReport) -> bool:
    if rng.random() < 0.5:
        return False
    path = copy / "events.jsonl"
    lines = path.read_bytes().split(b"\n")
    place = rng.randrange(6)
    before = lines[place]
    # Within the line: a bit that makes a line end, or takes one, damages two of them.
    while b"\n" in lines[place] or lines[place] == before:
        lines[place] = damage(before, "one bit", rng)
    path.write_bytes(b"\n".join(lines))
    report.lines += 1
    return True


def _read_as_found(copy: Path, trials: dict[int, Trial], report: DamageReport) -> None:
    """What a reader sees before any repair: the right trial, or a refusal."""
    if not (copy / "study.toml").exists():
        return
    with StudyStore.open(copy) as store:
        for number in store.numbers():
            try:
                trial = store.read_trial(number)
            except StoreError as refused:
                if "\n" in str(refused):
                    report.wrong.append(f"more than one line: {refused}")
                continue
            _compare(trial, trials[number], "read before the repair", report)
        store.events()


def _look_at_trials(
    copy: Path, kinds: dict[int, str], trials: dict[int, Trial], report: DamageReport
) -> None:
    with StudyStore.open(copy) as store:
        present = store.numbers()
        for number, expected in trials.items():
            if number in present:
                _compare(store.read_trial(number), expected, "read after it", report)
                if number in kinds:
                    report.mended[kinds[number]] += 1
            elif number in kinds:
                report.lost[kinds[number]] += 1
            else:
                report.wrong.append(f"trial {number} is gone")


def _compare(trial: Trial, expected: Trial, when: str, report: DamageReport) -> None:
    try:
        assert_same_trial(trial, expected)
    except AssertionError:
        report.wrong.append(f"trial {expected.number} is another when {when}")
