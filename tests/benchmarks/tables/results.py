"""Numbers in what the benchmarks printed."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

RESULTS = Path(__file__).resolve().parents[1] / "results"
MADE = tomllib.loads((RESULTS / "made.toml").read_text(encoding="utf-8"))


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
