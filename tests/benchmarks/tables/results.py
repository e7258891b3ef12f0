"""Numbers in what the benchmarks printed."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

RESULTS = Path(__file__).resolve().parents[1] / "results"
MADE = tomllib.loads((RESULTS / "made.toml").read_text(encoding="utf-8"))
_COUNTED = re.compile(r"^ *(\S.*?\S) {2,}(\d+) of (\d+) +(?:[\d.]+ %|-) +\[ *([\d.]+), *([\d.]+)\]")
_MEASURED = re.compile(r"^(\S.*?\S) {2,}(\d+) +(\d[\d.e+-]*)( %)?(?: |$)")


@dataclass(frozen=True)
class Compared:
    """How soon one method was near the optimum in a study.

    Attributes
    ----------
    median, mean : float
        Real runs until then, over the seeds.
    never : int
        [%] Share of the seeds on which it was not within the real runs that there were.
    seeds : int
        How many there are.
    """

    median: float
    mean: float
    never: int
    seeds: int


@dataclass(frozen=True)
class Counted:
    """How many of how many cases, with the 95 % interval [%] of their share."""

    hits: int
    cases: int
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.hits} of {self.cases}"


@dataclass(frozen=True)
class Round:
    """A round of the blind benchmark.

    Attributes
    ----------
    file : str
        What it printed, below `tests/benchmarks/results/`.
    made : dict
        `engine`, `committed` and perhaps a `remark`.
    command : str
        That made it.
    cases : int
        That were run.
    unnamed : int
        Cases without hidden physics that were told that something is missing, without a name.
    counted : dict
        Counts, by what is counted.
    measured : dict
        Medians, shares [%] and scores, by what is measured.
    """

    file: str
    made: dict[str, str]
    command: str
    cases: int
    unnamed: int
    counted: dict[str, Counted]
    measured: dict[str, float]


def commands(study: str) -> list[str]:
    """Commands that made the table of a comparison."""
    head = (RESULTS / study / "table.txt").read_text(encoding="utf-8").partition("\n\n")[0]
    return [line.removeprefix("$ ") for line in head.splitlines() if line.startswith("$ ")]


def compared(study: str) -> dict[str, Compared]:
    """What a comparison came to, by method."""
    rows = _part(study, "n*: real runs to the optimum")
    found = {}
    for row in rows:
        name, median, mean, never, seeds = re.findall(
            r"^(\w+) +([\d.]+) +\[.*?\] +([\d.]+) +\[.*?\] +\d+ +(\d+) % +(\d+)$", row
        )[0]
        found[name] = Compared(float(median), float(mean), int(never), int(seeds))
    return found


def fewer_runs(study: str, method: str) -> tuple[float, float, float]:
    """Mean of n* less that of `bo_ei` on the same seed, with its 95 % interval."""
    (row,) = (r for r in _part(study, "n* less that of bo_ei") if r.startswith(f"{method} "))
    mean, low, high = re.findall(r"-?[\d.]+", row)[:3]
    return float(mean), float(low), float(high)


def _part(study: str, title: str) -> list[str]:
    """Rows of one table of a comparison."""
    text = (RESULTS / study / "table.txt").read_text(encoding="utf-8")
    return text.partition(f"\n{title}")[2].partition("\n\n")[0].splitlines()[2:]


def rounds() -> list[Round]:
    """All rounds of the blind benchmark, the oldest first."""
    return [_round(made) for made in MADE["blind"]]


def _round(made: dict[str, str]) -> Round:
    text = (RESULTS / made["file"]).read_text(encoding="utf-8")
    cases = re.search(r"^Blind benchmark: (\d+) of", text, re.MULTILINE)
    assert cases is not None
    unnamed = re.search(r"^\(nothing\) +\(outside\) +(\d+)$", text, re.MULTILINE)
    lines = text.splitlines()
    counts = (_COUNTED.match(line) for line in lines)
    measures = (_MEASURED.match(line) for line in lines)
    return Round(
        file=made["file"],
        made=made,
        command=next(line for line in lines if line.startswith("$ ")).removeprefix("$ "),
        cases=int(cases[1]),
        unnamed=int(unnamed[1]) if unnamed else 0,
        counted={
            m[1]: Counted(int(m[2]), int(m[3]), float(m[4]), float(m[5])) for m in counts if m
        },
        measured={m[1]: float(m[3]) for m in measures if m},
    )
