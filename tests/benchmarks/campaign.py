"""What many studies cost: two processes against one, and a projection for a cluster.

    python -m tests.benchmarks.campaign [--seeds 12] \\
        [--out tests/benchmarks/results/campaign/campaign.txt]

Parallel efficiency: the same runs in one process and in two, starts of the processes counted. The
overhead of a unit on a cluster is that of a real dask scheduler and worker for units that their
worker refuses at once. The projection takes time, sizes and overhead from what was measured here;
only the bandwidth of the network is assumed. Run it on an idle machine.
"""

from __future__ import annotations

import argparse
import os
import pickle
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gmfbo import Study
from gmfbo.studies.campaign import GRID_SIDE, campaign
from gmfbo.studies.cluster import open_executor
from gmfbo.studies.comparison_folder import ComparisonFolder
from gmfbo.studies.dispatch import Dispatch
from gmfbo.studies.engine import OnExecutor
from gmfbo.studies.planned_comparison import PlannedComparison, Wanted
from gmfbo.studies.unit import Failed, Made, Unit
from gmfbo.studies.worker import carry_out
from gmfbo.tuning.methods import find_method

STUDY = Path(__file__).parent / "studies" / "noise_50.toml"
METHODS = ("bo_ei", "gmfbo")
STUDIES, WORKERS = 10_000, 100
BYTES_PER_S = 100e6
"""Assumed of the network."""


def runs_s(jobs: int, seeds: int, folder: Path) -> tuple[float, float]:
    """Wall clock of all runs, and the mean time of one; the plant is known before."""
    out = folder / f"jobs-{jobs}"
    campaign([STUDY], ["random"], 1, out=out)  # the plant over the box
    began = time.perf_counter()
    (result,) = campaign([STUDY], METHODS, seeds, out=out, jobs=jobs)
    wall = time.perf_counter() - began
    each = [sum(one.seconds) + one.seconds_before for one in result.outcomes]
    return wall, sum(each) / len(each)


def planned(folder: Path, seeds: int, *, keep_trials: bool) -> PlannedComparison:
    """The same runs as units."""
    methods = tuple((find_method(name), seeds) for name in METHODS)
    wanted = Wanted(methods, 0, GRID_SIDE, keep_trials)
    return PlannedComparison.begin(Study.read(STUDY), ComparisonFolder(folder), wanted)


def overhead_s(units: Sequence[Unit], folder: Path, rounds: int = 20) -> float:
    """Mean time of a unit that its worker, on a real dask scheduler, refuses at once."""
    port = "18786"
    scheduler = [sys.executable, "-m", "dask", "scheduler", "--port", port, "--no-dashboard"]
    worker = [sys.executable, "-m", "dask", "worker", f"tcp://127.0.0.1:{port}", "--no-nanny"]
    processes = [
        subprocess.Popen(command, cwd=folder, stderr=subprocess.DEVNULL)
        for command in (scheduler, [*worker, "--nthreads", "1", "--no-dashboard"])
    ]
    refused = [
        replace(unit, version="none", label=f"{unit.label} {round}")
        for round in range(rounds)
        for unit in units
    ]
    came: list[Made | Failed] = []
    try:
        with open_executor(f"dask:tcp://127.0.0.1:{port}") as executor:
            engine = OnExecutor(executor, 1)
            Dispatch(engine, {}, lambda unit, one: came.append(one)).run(refused[:1])  # imports
            began = time.perf_counter()
            Dispatch(engine, {}, lambda unit, one: came.append(one)).run(refused[1:])
            return (time.perf_counter() - began) / (len(refused) - 1)
    finally:
        for process in processes:
            process.kill()
            process.wait()


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("--seeds", type=int, default=12)
    asked.add_argument("--out", type=Path)
    options = asked.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        one, unit_s = runs_s(1, options.seeds, folder)
        two, unit_of_two_s = runs_s(2, options.seeds, folder)
        plan = planned(folder / "jobs-1" / "noise_50.compare", options.seeds + 1, keep_trials=True)
        units = plan.runs()
        made = carry_out(units[-1], plan.gathered.contents)
        assert isinstance(made, Made)
        files = sum(map(len, plan.gathered.contents.values()))
        sent, kept = len(pickle.dumps(units[0])), len(pickle.dumps(made))
        back = len(pickle.dumps(replace(made, record=None)))
        each_s = overhead_s(units, folder)
    busy = STUDIES * unit_s / WORKERS
    moved = (WORKERS * files + STUDIES * (sent + back)) / BYTES_PER_S
    handed = STUDIES * each_s
    text = "\n".join(
        [
            f"$ python -m tests.benchmarks.campaign --seeds {options.seeds}",
            f"Python {platform.python_version()}, {platform.system()} {platform.machine()}, "
            f"{os.cpu_count()} cores",
            f"{len(METHODS) * options.seeds} runs of noise_50, methods {', '.join(METHODS)}",
            f"one process      {one:8.1f} s, {unit_s:.2f} s a run",
            f"two processes    {two:8.1f} s, {unit_of_two_s:.2f} s a run",
            f"efficiency       {one / (2.0 * two):8.2f}",
            f"a unit           {sent / 1e3:8.1f} kB there, {back / 1e3:.1f} kB back "
            f"({kept / 1e6:.1f} MB with all its trials)",
            f"files, once      {files / 1e3:8.1f} kB to each worker",
            f"overhead         {1e3 * each_s:8.1f} ms a unit (dask scheduler, client and worker)",
            "",
            f"projected, {STUDIES} studies on {WORKERS} workers:",
            f"computing        {busy / 60.0:8.1f} min",
            f"transfers        {moved / 60.0:8.2f} min at {BYTES_PER_S / 1e6:.0f} MB/s (assumed), "
            f"{(moved + STUDIES * (kept - back) / BYTES_PER_S) / 60.0:.1f} min with all trials",
            f"handing out      {handed / 60.0:8.2f} min if it were not done meanwhile",
            f"in all           {(busy + moved + handed) / 60.0:8.1f} min at most, efficiency "
            f"{busy / (busy + moved + handed):.2f}",
            "",
        ]
    )
    print(text)
    if options.out is not None:
        options.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
