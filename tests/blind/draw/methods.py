"""Methods beside each other, on the cases that all of them ran.

python -m tests.blind.draw.methods gmfbo=OUTCOMES.jsonl stepwise=MORE.jsonl ... [--text FILE]
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from tests.blind.draw.judging import PHYSICS_CLAIMED, Judged, judge
from tests.blind.draw.outcomes import read_outcomes, tell

COLUMNS: Mapping[str, tuple[int, Callable[[Sequence[Judged]], str]]] = {
    "nulls claimed": (15, lambda own: _count(_nulls(own), lambda j: j.outcome in PHYSICS_CLAIMED)),
    "owed right": (14, lambda own: _count(_owed(own), lambda j: j.outcome == "right", ended=False)),
    "or a set": (
        12,
        lambda own: _count(_owed(own), lambda j: j.outcome in ("right", "set"), ended=False),
    ),
    "false name": (14, lambda own: _count(own, lambda j: bool(j.false_names))),
    "outside": (11, lambda own: _count(_outside(own), lambda j: j.verdict == "outside_library")),
    "failed": (10, lambda own: _count(own, lambda j: j.outcome == "failed", ended=False)),
    "error left": (12, lambda own: _median([j.error_left for j in _owed(own)], ".2f")),
    "runs": (8, lambda own: _median([j.simulations or None for j in own], ".0f")),
    "CPU s": (8, lambda own: _median([j.cpu_seconds for j in own], ".0f")),
}
"""Width and content of each column."""


def methods(outcomes: Mapping[str, Sequence[Judged]]) -> str:
    """Text: a line a method.

    Parameters
    ----------
    outcomes : mapping of str to sequence of Judged
        By method.
    """
    common = set.intersection(*({j.case for j in own} for own in outcomes.values()))
    head = f"{'method':<18}" + "".join(f"{name:>{width}}" for name, (width, _) in COLUMNS.items())
    lines = [
        f"Methods on the same {len(common)} cases; error left of owed cases, runs of the twin and "
        "seconds of processor time are medians",
        head,
    ]
    for title, judged in outcomes.items():
        own = [j for j in judged if j.case in common]
        cells = "".join(f"{cell(own):>{width}}" for width, cell in COLUMNS.values())
        lines.append(f"{title:<18}{cells}")
    return "\n".join(lines) + "\n"


def _nulls(judged: Sequence[Judged]) -> list[Judged]:
    return [j for j in judged if j.stratum == "null"]


def _owed(judged: Sequence[Judged]) -> list[Judged]:
    return [j for j in judged if j.stratum == "owed" and j.is_owed]


def _outside(judged: Sequence[Judged]) -> list[Judged]:
    return [j for j in judged if j.stratum == "outside"]


def _count(judged: Sequence[Judged], test: Callable[[Judged], bool], *, ended: bool = True) -> str:
    asked = [j for j in judged if j.outcome != "failed"] if ended else judged
    return f"{sum(test(j) for j in asked)} of {len(asked)}"


def _median(values: Sequence[float | None], spec: str) -> str:
    known = [value for value in values if value is not None and not math.isnan(value)]
    return format(float(np.median(known)), spec) if known else "-"


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.draw.methods."""
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").strip(), formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("outcomes", nargs="+", metavar="METHOD=FILE")
    parser.add_argument("--text", type=Path, help="file for the table")
    given = parser.parse_args(arguments)
    named = dict(one.split("=", 1) for one in given.outcomes)
    text = methods(
        {name: [judge(line) for line in read_outcomes(Path(file))] for name, file in named.items()}
    )
    tell(text, given.text)


if __name__ == "__main__":
    main()
