"""What isolation and sandbox cost, and what is left when gmfbo is killed at any moment.

    python tests/benchmarks/isolation.py [--repeats 200] [--kills 100] [--seed 0]

A run is one of a twin that begins as its FMU begins; the three ways take turns, so that what else
the machine does meets all alike. A time is the fastest of the repeats; processor time, which a busy
machine changes less, is the mean over them, of gmfbo and its worker together. Each kill is a
SIGKILL to a process that simulates without pause, at a random moment after its first run; then
every process that it had started has to be gone, and its temporary folder.
"""

from __future__ import annotations

import argparse
import os
import platform
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from gmfbo import FmuTwin, Recording  # noqa: E402
from gmfbo.sources.fmu_file.models import models_folder  # noqa: E402
from gmfbo.sources.sandbox.enclosure import available  # noqa: E402
from tests.sources.worker.processes import descendants, gone_within  # noqa: E402

RESULT = Path(__file__).parent / "results" / "isolation" / "isolation.txt"
STEP_S = 1e-3
HORIZON_S = 1.1
CASES = {"linear_axis": "initial_position", "drive_twin": "initial.position"}
WAYS = ("in process", "isolated", "isolated, sandbox")
VICTIM = """
import sys
import numpy as np
from gmfbo import FmuTwin, Recording
ramp = Recording(time=1e-3 * np.arange(101), signals={"reference": np.arange(101.0)})
with FmuTwin(sys.argv[1]) as twin:
    twin.run({}, ramp)
    print("ready", flush=True)
    while True:
        twin.run({}, ramp)
"""


def twin_file(folder: Path, model: str, initial: str) -> Path:
    """Twin file that begins as the FMU begins: one simulation a run."""
    path = folder / f"{model}.toml"
    path.write_text(
        f'name = "{model}"\nfmu = "{models_folder() / model}.fmu"\nstep = {STEP_S}\n'
        f'[inputs]\nreference = "reference"\n[outputs]\nposition = "position"\n'
        f'velocity = "velocity"\n[initial]\n"{initial}" = 0.0\n[gains]\n',
        encoding="utf-8",
    )
    return path


def seconds_of(action: Callable[[], object]) -> float:
    """Wall-clock time [s]."""
    began = time.perf_counter()
    action()
    return time.perf_counter() - began


def processor_seconds(workers: list[int]) -> float:
    """Processor time [s] of this process and of those; the kernel counts nanoseconds."""
    theirs = (Path(f"/proc/{worker}/schedstat").read_text().split()[0] for worker in workers)
    return time.process_time() + 1e-9 * sum(map(int, theirs))


def run_times(path: Path, reference: Recording, repeats: int) -> dict[str, list[float]]:
    """Time [s] of a run by kind, for each way."""
    with ExitStack() as stack:
        runs, first, used = [], [], []
        for way in WAYS:
            os.environ["GMFBO_SANDBOX"] = "on" if "sandbox" in way else "off"
            twin = stack.enter_context(FmuTwin(path, isolated=way != "in process"))
            runs.append(partial(twin.run, {}, reference))
            first.append(seconds_of(runs[-1]))
        turns = [[seconds_of(run) for run in runs] for _ in range(repeats)]
        workers = descendants(os.getpid())
        for run in runs:
            before = processor_seconds(workers)
            for _ in range(repeats):
                run()
            used.append((processor_seconds(workers) - before) / repeats)
    return {"fastest": list(np.min(turns, axis=0)), "processor": used, "first run": first}


def overhead(repeats: int) -> list[str]:
    """Lines of the table."""
    lines = [f"{'':<14}" + "".join(f"{way:>20}" for way in WAYS) + "   ratio"]
    rows = round(HORIZON_S / STEP_S) + 1
    with tempfile.TemporaryDirectory() as folder:
        for model, initial in CASES.items():
            path = twin_file(Path(folder), model, initial)
            grid = np.arange(rows, dtype=np.float64) * np.float64(STEP_S)
            reference = Recording(time=grid, signals={"reference": (grid >= 0.1).astype(float)})
            lines.append(f"{model}, {rows - 1} steps")
            for kind, times in run_times(path, reference, repeats).items():
                cells = "".join(f"{1e3 * t:>17.3f} ms" for t in times)
                lines.append(f"  {kind:<12}{cells}{times[2] / times[0]:>8.2f}")
    return lines


def kill_rounds(kills: int, seed: int) -> list[str]:
    """Lines that tell what was left."""
    rng = random.Random(seed)
    processes = folders = 0
    with tempfile.TemporaryDirectory() as folder:
        temporary = Path(folder) / "temporary"
        temporary.mkdir()
        path = twin_file(Path(folder), "linear_axis", "initial_position")
        for _ in range(kills):
            victim = subprocess.Popen(
                [sys.executable, "-c", VICTIM, str(path)],
                stdout=subprocess.PIPE,
                env={**os.environ, "TMPDIR": str(temporary), "GMFBO_SANDBOX": "on"},
            )
            assert victim.stdout is not None
            victim.stdout.readline()
            time.sleep(rng.uniform(0.0, 0.1))
            started = descendants(victim.pid)
            victim.kill()
            victim.wait()
            processes += not gone_within(started, 5.0)
            folders += len(list(temporary.iterdir()))
    return [
        f"gmfbo killed by SIGKILL in a run     {kills:5d}",
        f"kills that left a process            {processes:5d}",
        f"temporary folders left               {folders:5d}",
    ]


def main() -> int:
    """Print and write both tables; exit status 1 where something was left."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=200)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    here = available()
    left = kill_rounds(given.kills, given.seed)
    text = "\n".join(
        [
            "$ python tests/benchmarks/isolation.py "
            f"--repeats {given.repeats} --kills {given.kills} --seed {given.seed}",
            f"Python {platform.python_version()}, {platform.system()} {platform.machine()}, "
            f"{os.cpu_count()} cores, landlock {here.landlock}, seccomp {here.seccomp}",
            "",
            *overhead(given.repeats),
            "",
            *left,
            "",
        ]
    )
    RESULT.write_text(text, encoding="utf-8")
    print(text, end="")
    return 0 if all(line.endswith(" 0") for line in left[1:]) else 1


if __name__ == "__main__":
    sys.exit(main())
