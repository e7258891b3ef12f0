"""Studies with an envelope: how many of their runs leave it.

    python -m tests.benchmarks.plants.safety [--methods A,B] [--plants P,Q] [--seeds 20:25]

The response must not go 25 % of the step beyond it, which between a quarter and two thirds of each
box do; gains in force do not. Lines lie in `results/safety/PLANT/METHOD.jsonl`.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from tests.benchmarks.plants.arrival import read_lines
from tests.benchmarks.plants.catalogue import PLANTS, Plant
from tests.benchmarks.plants.run import RESULTS, in_this_process, run_plants

METHODS = ("gmfbo_estimated", "bo_ei", "log_ei", "identify_then_optimise")

BEYOND = 0.25
"""Share of the step by which a response may go beyond it, and back behind its beginning."""

LIMITED = ("servo_axis", "linear_axis", "temperature", "mujoco_belt")

FOLDER = RESULTS / "safety"


def with_envelope(plant: Plant) -> Plant:
    """The plant, whose study has an envelope about its step."""
    file = plant.study().file
    begin, step = file.reference.start, file.reference.step
    room = BEYOND * step
    return replace(plant, safety={file.objective.signal: (begin - room, begin + step + room)})


def left(lines: Sequence[Mapping[str, Any]], method: str, plants: Sequence[str]) -> tuple[int, int]:
    """How many runs of a method left the envelope, and of how many after the initial ones."""
    status = [
        word
        for line in lines
        if line["method"] == method and line["plant"] in plants
        for word in line["status"][line["initial"] :]
    ]
    return status.count("unsafe"), len(status)


def table(lines: Sequence[Mapping[str, Any]]) -> str:
    """Runs after the initial ones that left the envelope, and of how many."""
    rows = ["left the envelope, of the runs after the initial ones"]
    for method in METHODS:
        cells = []
        for plants in (*((name,) for name in LIMITED), LIMITED):
            gone, count = left(lines, method, plants)
            name = plants[0] if len(plants) == 1 else "all"
            cells.append(f"{name} {gone}/{count}")
        rows.append(f"{method:22s} " + ", ".join(cells))
    return "\n".join(rows) + "\n"


def main() -> None:
    """Make the studies that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--plants", default=",".join(LIMITED))
    parser.add_argument("--seeds", default="20:25", help="FIRST:END")
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args()
    in_this_process()
    first, _, end = options.seeds.partition(":")
    plants = [with_envelope(PLANTS[name]) for name in options.plants.split(",")]
    run_plants(plants, options.methods.split(","), range(int(first), int(end)), options.out)
    print(table(read_lines(options.out)), end="")


if __name__ == "__main__":
    main()
