"""What `gmfbo demo` finds of what it hides, seed by seed.

The second part of the demo alone, at its own defaults: draw, recordings, diagnosis, comparison.

    python -m tests.benchmarks.demo_seeds --seeds 48 \\
        > tests/benchmarks/results/demo_seeds/demo_seeds.txt
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

from gmfbo import diagnose
from gmfbo.cli.hidden.draw import Draw, draw
from gmfbo.cli.hidden.effects import EFFECTS
from gmfbo.cli.hidden.recordings import record
from gmfbo.cli.hidden.reveal import answer_lines, judged
from gmfbo.diagnosis import Diagnosis
from gmfbo.errors import GmfboError
from gmfbo.sources.fmu_file.models import models_folder
from tests.blind.draw.measures import clopper_pearson

NOMINAL = {"inertia": 0.01, "viscous": 0.05}  # of models/servo_axis.fmu


def held(drawn: Draw, diagnosis: Diagnosis) -> list[bool]:
    """Whether each interval of 95 % holds the truth: of what was named right, and the twin's own.

    Sizes that follow from several values, such as an amplitude, have no interval.
    """
    own = diagnosis.parameters
    found = [
        own[name].low <= drawn.plant.get(name, value) <= own[name].high
        for name, value in NOMINAL.items()
        if name in own and own[name].identifiable
    ]
    hidden = next((one for one in EFFECTS if one.name == drawn.hidden), None)
    named = next((one for one in diagnosis.effects if one.name == drawn.hidden), None)
    if hidden is None or named is None:
        return found
    values = {name: one.value for name, one in named.parameters.items()}
    for size in hidden.sizes:
        ends = [
            sorted(size.found({**values, name: end}) for end in (one.low, one.high))
            for name, one in named.parameters.items()
            if np.isfinite([one.low, one.high]).all()
        ]
        moved = [(low, high) for low, high in ends if low < high]
        if len(moved) == 1:
            found.append(moved[0][0] <= size.true(drawn.plant) <= moved[0][1])
    return found


def row(seed: int) -> tuple[str, str, list[bool]]:
    """Return the mark and the line of a seed, and which of its intervals hold."""
    drawn = draw(seed)
    with tempfile.TemporaryDirectory() as folder:
        recordings = record(drawn.plant, seed, Path(folder))
        began = time.perf_counter()
        try:
            diagnosis = diagnose(models_folder() / "servo_axis.toml", recordings)
        except GmfboError as error:
            return "failed", f"{seed:4d}  {drawn.hidden:<23} failed: {error}", []
        seconds = time.perf_counter() - began
    named = " + ".join(
        "/".join((effect.name, *effect.indistinguishable_from)) for effect in diagnosis.effects
    )
    mark = judged(drawn, diagnosis)
    sizes = "; ".join(" ".join(line.split()) for line in answer_lines(drawn, diagnosis)[2:-2])
    line = f"{seed:4d}  {drawn.hidden:<23} {named or f'({diagnosis.verdict})':<43} {mark:<15}"
    holding = held(drawn, diagnosis) if mark == "right" else []
    kept = f"{sum(holding)}/{len(holding)}"
    told = f"{line} {diagnosis.cost.simulations:6d} {seconds:6.1f} {kept:>6}  {sizes}"
    return mark, told.rstrip(), holding


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=24, help="how many")
    parser.add_argument("--first", type=int, default=0, help="the first one")
    given = parser.parse_args()
    command = f"python -m tests.benchmarks.demo_seeds --seeds {given.seeds} --first {given.first}"
    cores = len(os.sched_getaffinity(0))
    print(f"$ {command}\n(seconds are of the diagnosis alone, on {cores} cores)\n")
    print("seed  hidden                  found (/ cannot be told from)               ", end="")
    print("mark              runs  s       held   sizes: hidden, found")
    marks: Counter[str] = Counter()
    holding: list[bool] = []
    for seed in range(given.first, given.first + given.seeds):
        mark, line, own = row(seed)
        marks[mark] += 1
        holding += own
        print(line, flush=True)
    print("\n" + ", ".join(f"{mark}: {count}" for mark, count in marks.most_common()))
    low, high = clopper_pearson(sum(holding), len(holding))
    print(
        f"intervals of 95 % that hold the truth, where the mark is right: {sum(holding)} of "
        f"{len(holding)} [{100.0 * low:.1f}, {100.0 * high:.1f}] %"
    )


if __name__ == "__main__":
    main()
