"""Placebos: benchmark cases with something wrong in what the tool is told.

    python -m tests.blind.placebo swap --out FOLDER --to PLACEBO [--count 24] [--only 003 007]
    python -m tests.blind.run --out PLACEBO
    python -m tests.blind.placebo --line PLACEBO [PLACEBO ...]

swap         recordings 1 and 3 of two units without hidden physics are exchanged: no one set of
             parameters fits all; any name is a failure
exclude      the true effect (of friction: the whole family) is ruled out with --exclude: another
             name of a probability of 0.5 or more is a failure
noise_half, noise_double
             what is faster than 250 Hz, by which the tool estimates noise, times 0.5 or 2 in
             position and command: a wrong name is a failure
gain         the first gain of the controller is 5 % higher in twin and recordings than it was
             in truth: a wrong name is a failure
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind.generate import answer_path, check_hashes, write_hashes
from tests.blind.hidden import FRICTION
from tests.blind.machines import MACHINES
from tests.blind.score import OWED, Scored, read_scores

Answers = Mapping[str, Mapping[str, Any]]

FASTER_THAN = 250.0
"""[Hz] Above what the diagnosis compares, below where it reads the noise."""

CONFIDENT = 0.5
GAIN_ERROR = 1.05
_COUNT = 24


def make_placebo(kind: str, out: Path, to: Path, count: int, only: Sequence[str] = ()) -> list[str]:
    """Write a folder of changed cases with their answers and hashes; answers the cases.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    out, to : Path
        Folder of the benchmark, and of the placebo.
    count : int
        Cases at most.
    only : sequence of str
        Cases to choose from; all that suit if empty.

    Raises
    ------
    ValueError
        No case suits.
    """
    known = check_hashes(out)
    answers = {
        case: json.loads(answer_path(out, int(case)).read_text(encoding="utf-8")) for case in known
    }
    chosen = _suited(kind, {c: a for c, a in answers.items() if not only or c in only})[:count]
    if not chosen:
        raise ValueError(f"expected cases that suit '{kind}', found none in {out}")
    for folder in ("answers", "cases", "arguments"):
        (to / folder).mkdir(parents=True, exist_ok=True)
    for case in chosen:
        shutil.copytree(out / "cases" / case, to / "cases" / case, dirs_exist_ok=True)
        _move_twin(to / "cases" / case / "twin.toml", out / "cases" / case, to / "cases" / case)
        shutil.copy(answer_path(out, int(case)), answer_path(to, int(case)))
    KINDS[kind](to, {case: answers[case] for case in chosen})
    benchmark = json.loads((out / "benchmark.json").read_text(encoding="utf-8"))
    (to / "benchmark.json").write_text(json.dumps({**benchmark, "placebo": kind}), "utf-8")
    write_hashes(to)
    return chosen


def _suited(kind: str, answers: Answers) -> list[str]:
    """Nulls for a swap, owed single effects where one is excluded, both in turn elsewhere."""
    nulls = [c for c, a in answers.items() if a["kind"] == "null" and a["ports"]]
    owed = [
        c
        for c, a in answers.items()
        if a["kind"] == "single" and a["within_reach"] and a["oracle_gain"] > OWED
    ]
    if kind == "swap":
        free = [c for c in nulls if MACHINES[answers[c]["machine"]].free]
        free.sort(key=lambda c: str(answers[c]["machine"]))
        pairs = [
            (a, b) for a, b in pairwise(free) if answers[a]["machine"] == answers[b]["machine"]
        ]
        return list(dict.fromkeys(case for pair in pairs[::2] for case in pair))
    if kind == "exclude":
        return owed
    if kind == "gain":
        nulls = [c for c in nulls if MACHINES[answers[c]["machine"]].gains]
        owed = [c for c in owed if MACHINES[answers[c]["machine"]].gains]
    return [case for pair in zip(nulls, owed, strict=False) for case in pair]


def _move_twin(file: Path, before: Path, now: Path) -> None:
    """The same FMUs from another folder."""

    def moved(match: re.Match[str]) -> str:
        return f'"{(before / match[1]).resolve().as_posix()}"'

    text = file.read_text(encoding="utf-8")
    file.write_text(re.sub(r'"([^"]*\.fmu)"', moved, text), encoding="utf-8")


def _swap(to: Path, answers: Answers) -> None:
    cases = list(answers)
    for a, b in zip(cases[::2], cases[1::2], strict=False):
        for name in ("rec1.csv", "rec3.csv"):
            one, other = to / "cases" / a / name, to / "cases" / b / name
            texts = one.read_bytes(), other.read_bytes()
            one.write_bytes(texts[1])
            other.write_bytes(texts[0])


def _exclude(to: Path, answers: Answers) -> None:
    for case, answer in answers.items():
        name = answer["effects"][0]["name"]
        names = sorted(FRICTION) if name in FRICTION else [name]
        arguments = [word for each in names for word in ("--exclude", each)]
        (to / "arguments" / f"{case}.json").write_text(json.dumps(arguments), encoding="utf-8")


def _noise(factor: float) -> Callable[[Path, Answers], None]:
    def change(to: Path, answers: Answers) -> None:
        for case in answers:
            for path in sorted((to / "cases" / case).glob("rec*.csv")):
                path.write_text(with_noise(path.read_text(encoding="utf-8"), factor), "utf-8")

    return change


def with_noise(text: str, factor: float) -> str:
    """A recording whose fastest part is another; time and reference stay.

    Parameters
    ----------
    text : str
        CSV of a recording.
    factor : float
        On everything faster than `FASTER_THAN`.
    """
    lines = text.splitlines()
    first = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    names = lines[first].split(",")
    table = np.array([line.split(",") for line in lines[first + 1 :]], dtype=float)
    fast = np.fft.rfftfreq(len(table), 1e-3) > FASTER_THAN
    for k, name in enumerate(names):
        if not name.startswith(("time", "reference")):
            spectrum = np.fft.rfft(table[:, k])
            spectrum[fast] *= factor
            table[:, k] = np.fft.irfft(spectrum, len(table))
    rows = [",".join(f"{cell:.9g}" for cell in row) for row in table.tolist()]
    return "\n".join([*lines[: first + 1], *rows, ""])


def _gain(to: Path, answers: Answers) -> None:
    for case, answer in answers.items():
        name = next(iter(MACHINES[answer["machine"]].gains.values()))
        for path in sorted((to / "cases" / case).iterdir()):
            text = path.read_text(encoding="utf-8")
            path.write_text(_scaled(text, name, GAIN_ERROR), encoding="utf-8")


def _scaled(text: str, name: str, factor: float) -> str:
    """The value of a parameter, as a `#` line or in a table, times a factor."""

    def more(match: re.Match[str]) -> str:
        return f"{match[1]}{float(match[2]) * factor:.6g}"

    pattern = rf'^((?:# )?"?{re.escape(name)}"? = )([-+.\deE]+)'
    return re.sub(pattern, more, text, flags=re.MULTILINE)


KINDS: Mapping[str, Callable[[Path, Answers], None]] = {
    "swap": _swap,
    "exclude": _exclude,
    "noise_half": _noise(0.5),
    "noise_double": _noise(2.0),
    "gain": _gain,
}


def placebo_fails(kind: str, score: Scored) -> bool:
    """Whether a case names what its placebo forbids."""
    if kind == "exclude":
        return any(probability >= CONFIDENT for probability, _ in score.claims)
    return bool(score.named) if kind == "swap" else score.outcome == "wrong"


def placebo_table(folders: Sequence[Path]) -> str:
    """Text: a line a placebo, then its failures."""
    lines = [f"{'placebo':<16}{'cases':>6}{'failures':>9}{'named right':>12}{'outside':>8}"]
    failed = []
    for folder in folders:
        kind = json.loads((folder / "benchmark.json").read_text(encoding="utf-8"))["placebo"]
        scores = read_scores(folder)
        bad = [s for s in scores if placebo_fails(kind, s)]
        right = sum(bool(s.named) and s.outcome == "right" for s in scores)
        outside = sum(s.verdict == "outside_library" for s in scores)
        lines.append(f"{kind:<16}{len(scores):>6}{len(bad):>9}{right:>12}{outside:>8}")
        failed += [
            f"{kind} {s.case} {s.machine}: hidden {' + '.join(s.hidden) or '-'}, named "
            + ", ".join(f"{n} ({p:.2f})" for n, (p, _) in zip(s.named, s.claims, strict=True))
            for s in bad
        ]
    return "\n".join(["Placebos", *lines, *failed])


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.placebo."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kind", nargs="?", choices=sorted(KINDS))
    parser.add_argument("--out", type=Path, help="folder of the benchmark")
    parser.add_argument("--to", type=Path, help="folder to write")
    parser.add_argument("--count", type=int, default=_COUNT)
    parser.add_argument("--only", nargs="+", default=[], metavar="CASE")
    parser.add_argument("--line", nargs="+", type=Path, default=[], help="folders to report on")
    given = parser.parse_args(arguments)
    if given.line:
        print(placebo_table(given.line))
    elif given.kind and given.out and given.to:
        chosen = make_placebo(given.kind, given.out, given.to, given.count, given.only)
        print(f"{len(chosen)} cases in {given.to}: {' '.join(chosen)}")
    else:
        parser.error("expected a kind with --out and --to, or --line")


if __name__ == "__main__":
    main()
