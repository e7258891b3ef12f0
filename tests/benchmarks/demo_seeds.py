"""What `gmfbo demo` finds of what it hides, seed by seed.

The second part of the demo alone, at its own defaults: draw, recordings, diagnosis, comparison.

    python tests/benchmarks/demo_seeds.py --seeds 24 \\
        > tests/benchmarks/results/demo_seeds/demo_seeds.txt
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections import Counter
from pathlib import Path

from gmfbo import diagnose
from gmfbo.cli.hidden.draw import draw
from gmfbo.cli.hidden.recordings import record
from gmfbo.cli.hidden.reveal import answer_lines, judged
from gmfbo.errors import GmfboError
from gmfbo.sources.fmu_file.models import models_folder


def row(seed: int) -> tuple[str, str]:
    """Return the mark and the line of a seed."""
    drawn = draw(seed)
    with tempfile.TemporaryDirectory() as folder:
        recordings = record(drawn.plant, seed, Path(folder))
        began = time.perf_counter()
        try:
            diagnosis = diagnose(models_folder() / "servo_axis.toml", recordings)
        except GmfboError as error:
            return "failed", f"{seed:4d}  {drawn.hidden:<23} failed: {error}"
        seconds = time.perf_counter() - began
    named = " + ".join(
        "/".join((effect.name, *effect.indistinguishable_from)) for effect in diagnosis.effects
    )
    mark = judged(drawn, diagnosis)
    sizes = "; ".join(" ".join(line.split()) for line in answer_lines(drawn, diagnosis)[2:-2])
    line = f"{seed:4d}  {drawn.hidden:<23} {named or f'({diagnosis.verdict})':<43} {mark:<15}"
    return mark, f"{line} {diagnosis.cost.simulations:6d} {seconds:6.1f}  {sizes}".rstrip()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=24, help="how many")
    parser.add_argument("--first", type=int, default=0, help="the first one")
    given = parser.parse_args()
    command = f"python tests/benchmarks/demo_seeds.py --seeds {given.seeds} --first {given.first}"
    cores = len(os.sched_getaffinity(0))
    print(f"$ {command}\n(seconds are of the diagnosis alone, on {cores} cores)\n")
    print("seed  hidden                  found (/ cannot be told from)               ", end="")
    print("mark              runs  s       sizes: hidden, found")
    marks: Counter[str] = Counter()
    for seed in range(given.first, given.first + given.seeds):
        mark, line = row(seed)
        marks[mark] += 1
        print(line, flush=True)
    print("\n" + ", ".join(f"{mark}: {count}" for mark, count in marks.most_common()))


if __name__ == "__main__":
    main()
