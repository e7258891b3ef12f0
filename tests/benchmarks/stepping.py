"""Cost of stepping FMUs: gmfbo's driver against a C program, fmpy, and itself in a worker.

    python tests/benchmarks/stepping.py

All run in one go on the same FMU binaries with the same FMI calls. The C program (stepping.c) is
compiled by the `ziglang` package. A time is the fastest of several runs, and a run includes making
and freeing the instance.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

from gmfbo import FmuTwin, Recording
from gmfbo.sources.fmu_file.models import models_folder

HERE = Path(__file__).parent
RESULT = HERE / "results" / "stepping" / "stepping.txt"
STEP_S = 1e-3
CASES = {"linear_axis": ("initial_position", 20.0), "drive_twin": ("initial.position", 1.1)}
REPEATS = 40


def twin_file(folder: Path, model: str, initial: str) -> Path:
    """Twin file that begins as the FMU begins, so that all contenders make the same calls."""
    path = folder / f"{model}.toml"
    path.write_text(
        f'name = "{model}"\nfmu = "{models_folder() / model}.fmu"\nstep = {STEP_S}\n'
        f'[inputs]\nreference = "reference"\n[outputs]\nposition = "position"\n'
        f'velocity = "velocity"\n[initial]\n"{initial}" = 0.0\n[gains]\n'
    )
    return path


def step_reference(duration: float) -> Recording:
    """Unit step at 0.1 s."""
    time_s = np.arange(round(duration / STEP_S) + 1, dtype=np.float64) * np.float64(STEP_S)
    return Recording(time=time_s, signals={"reference": (time_s >= 0.1 - 1e-9).astype(float)})


def fastest(action: Callable[[], object], repeats: int = REPEATS) -> float:
    """Least wall-clock time [s] of some runs."""
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def c_program(folder: Path) -> Path:
    """Compile stepping.c."""
    program = folder / "stepping"
    command = [sys.executable, "-m", "ziglang", "cc", "-O2", "-o", str(program)]
    subprocess.run([*command, str(HERE / "stepping.c"), "-ldl"], check=True, capture_output=True)
    return program


def c_seconds(program: Path, unpacked: Path, model: str, steps: int) -> float:
    """Time [s] of the C program's fastest run."""
    description = fmpy.read_model_description(str(unpacked))
    references = {v.name: v.valueReference for v in description.modelVariables}
    library = next((unpacked / "binaries" / "linux64").glob("*.so"))
    finished = subprocess.run(
        [
            str(program),
            str(library),
            description.guid,
            (unpacked / "resources").as_uri(),
            str(steps),
            str(STEP_S),
            str(REPEATS),
            str(references["reference"]),
            str(references["position"]),
            str(references["velocity"]),
        ],
        check=True,
        capture_output=True,
        text=True,
    )
    return float(finished.stdout.split()[0])


def fmpy_seconds(unpacked: Path, reference: Recording) -> float:
    """Time [s] of fmpy's own stepping, one call a set, step and get."""
    description = fmpy.read_model_description(str(unpacked))
    references = {v.name: v.valueReference for v in description.modelVariables}
    wanted = [references["position"], references["velocity"]]
    values = reference.signal("reference")
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=str(unpacked),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="peer",
    )

    def run() -> None:
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        for row in range(len(values) - 1):
            slave.setReal([references["reference"]], [values[row]])
            slave.doStep(row * STEP_S, STEP_S)
            slave.getReal(wanted)
        slave.terminate()
        slave.fmi2FreeInstance(slave.component)

    return fastest(run, 8)


def main() -> None:
    """Print and write the table."""
    folder = Path(tempfile.mkdtemp(prefix="gmfbo-stepping-"))
    lines = ["$ python tests/benchmarks/stepping.py", f"{os.cpu_count()} cores", ""]
    lines.append(
        f"{'':<14}{'steps':>7}{'C':>10}{'gmfbo':>10}{'worker':>10}{'fmpy':>10}  [ms a run]"
    )
    ratios = []
    try:
        program = c_program(folder)
        for model, (initial, duration) in CASES.items():
            unpacked = Path(
                fmpy.extract(str(models_folder() / f"{model}.fmu"), str(folder / model))
            )
            reference, path = step_reference(duration), twin_file(folder, model, initial)
            steps = len(reference) - 1
            floor = c_seconds(program, unpacked, model, steps)
            peer = fmpy_seconds(unpacked, reference)
            with FmuTwin(path, isolated=False) as near, FmuTwin(path) as far:
                inside = fastest(partial(near.run, {}, reference))
                worker = fastest(partial(far.run, {}, reference))
            times = "".join(f"{1e3 * t:>10.3f}" for t in (floor, inside, worker, peer))
            lines.append(f"{model:<14}{steps:>7}{times}")
            ratios.append(
                f"{model:<14} gmfbo / C {inside / floor:.2f}   fmpy / gmfbo {peer / inside:.1f}   "
                f"worker / in process {worker / inside:.2f}"
            )
    finally:
        shutil.rmtree(folder)
    text = "\n".join([*lines, "", *ratios]) + "\n"
    RESULT.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
