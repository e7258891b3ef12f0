"""Time of a diagnosis: four recordings of 2.5 s at 1 kHz on a slow twin.

    python tests/benchmarks/diagnosis_speed.py \\
        > tests/benchmarks/results/diagnosis_speed/diagnosis_speed.txt

The twin is the drive of models/drive_twin.toml, whose current loop and flux map make it the
slowest of the models here. Its recordings come from the same FMU with friction, with another
inertia, or unchanged; the twin that is diagnosed has no friction, or is the same.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable

import numpy as np

from gmfbo import FmuTwin, Recording, diagnose
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

TWIN = models_folder() / "drive_twin.toml"
ROWS, SAMPLE_S = 2500, 1e-3
GAINS = {"ctl.Kp": 120.0, "ctl.Kd": 5.0}
WITHOUT_FRICTION = {"friction.coulomb": 0.0, "friction.stribeck": 0.0}
CASES = {
    "nothing hidden": ({}, {}),
    "another inertia": ({"load.inertia": 0.15}, {}),
    "friction hidden": ({}, WITHOUT_FRICTION),
    "friction hidden, another inertia": ({"load.inertia": 0.15}, WITHOUT_FRICTION),
    "friction doubled": ({"friction.scale": 2.0}, {}),
}


def main() -> int:
    """Print the time of one run, and of each diagnosis."""
    reference = references()[0]
    with FmuTwin(TWIN) as twin, AugmentedTwin(twin, substeps=5) as augmented:
        twin.run({}, reference)
        plan = augmented.plan(reference, {})
        augmented.run(plan, {})
        alone = timed(lambda: twin.run({}, reference))
        wired = timed(lambda: augmented.run(plan, {}))
    print(f"one recording: {1e3 * alone:.1f} ms by the twin, {1e3 * wired:.1f} ms with physics")
    print(f"{'case':<34}{'seconds':>8}{'runs':>7}  verdict, effects")
    seconds = []
    for name, (axis, given) in CASES.items():
        with FmuTwin(TWIN, parameters=given) as twin:
            found = diagnose(twin, recordings(axis), seed=0, jobs=2)
        seconds.append(found.cost.seconds)
        effects = ", ".join(effect.name for effect in found.effects) or "-"
        cost = f"{found.cost.seconds:>8.1f}{found.cost.simulations:>7}"
        print(f"{name:<34}{cost}  {found.verdict}, {effects}", flush=True)
    print(f"median {statistics.median(seconds):.1f} s on two simulators")
    return 0


def timed(run: Callable[[], object]) -> float:
    """Median time of ten runs [s]."""
    spent = []
    for _ in range(10):
        began = time.perf_counter()
        run()
        spent.append(time.perf_counter() - began)
    return statistics.median(spent)


def references() -> list[Recording]:
    """Four motions with reversals, none alike."""
    clock = np.arange(ROWS, dtype=np.float64) * SAMPLE_S
    found = []
    for k, (hertz, size) in enumerate([(0.5, 0.5), (0.9, 0.4), (1.4, 0.3), (2.3, 0.2)]):
        wave = size * np.sin(2.0 * np.pi * hertz * clock)
        wave = wave + 0.05 * np.sin(2.0 * np.pi * 7.1 * clock + k)
        found.append(Recording(time=clock, signals={"reference": wave}, parameters=GAINS))
    return found


def recordings(axis: dict[str, float]) -> list[Recording]:
    """What the axis did, with noise on its torque."""
    rng = np.random.default_rng(0)
    made = []
    with FmuTwin(TWIN, parameters=axis) as true:
        for k, reference in enumerate(references()):
            run = true.run({}, reference)
            noise = 0.05 * rng.standard_normal(ROWS)
            signals = {
                "reference": reference.signal("reference"),
                "position": run.signal("position"),
                "torque_command": run.signal("torque_command") + noise,
            }
            name = f"rec{k}.csv"
            made.append(
                Recording(time=reference.time, signals=signals, name=name, parameters=GAINS)
            )
    return made


if __name__ == "__main__":
    sys.exit(main())
