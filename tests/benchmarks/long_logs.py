"""Time of a diagnosis of much that was recorded: 60 recordings of 2 s, and one of ten minutes.

    python -m tests.benchmarks.long_logs \\
        > tests/benchmarks/results/long_logs/long_logs.txt

An open-loop motor without friction in its twin is driven by sums of sines at 1 kHz; its axis has
0.03 N m of Coulomb friction, another inertia and viscous friction, and an encoder's noise.
"""

from __future__ import annotations

import sys

import numpy as np

from gmfbo import FmuTwin, Recording, diagnose, models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

SAMPLE_S, NOISE = 1e-3, 3e-5  # [s], [rad]
AXIS = {"inertia": 0.0063, "viscous": 0.02}
HIDDEN = {"coulomb_friction.level": 0.03, "coulomb_friction.deflection": 1e-6}
CASES = {"60 recordings of 2 s": (60, 2.0), "one recording of 600 s": (1, 600.0)}


def recordings(twin: FmuTwin, count: int, seconds: float) -> list[Recording]:
    """What the axis did, under currents of which none is like another."""
    rng, made = np.random.default_rng(3), []
    time = np.arange(round(seconds / SAMPLE_S), dtype=np.float64) * SAMPLE_S
    with AugmentedTwin(twin, substeps=10) as axis:
        for k in range(count):
            hertz, size, phase = rng.uniform([0.3, 0.1, 0.0], [3.0, 0.4, 6.0], (3, 3)).T
            waves = np.sin(2.0 * np.pi * np.outer(time, hertz) + phase) @ size
            asked = Recording(time=time, signals={"current": waves}, name=f"rec{k}.csv")
            run = axis.run(axis.plan(asked, AXIS), AXIS, HIDDEN)
            position = run.held["position"] + NOISE * rng.standard_normal(time.size)
            signals = {"current": waves, "position": position}
            made.append(Recording(time=time, signals=signals, name=asked.name))
    return made


def main() -> int:
    """Print the time of each diagnosis, and what it says."""
    twin = FmuTwin(models_folder() / "motor_bench.toml")
    print(f"{'case':<26}{'seconds':>8}{'runs':>8}  effects; held-out errors of the position")
    for name, (count, seconds) in CASES.items():
        found = diagnose(twin, recordings(twin, count, seconds), seed=0, jobs=2)
        effects = ", ".join("/".join(effect.set) for effect in found.effects) or found.verdict
        errors = found.fit.signals["position"]
        told = [errors.nominal, errors.parameters_only, errors.augmented, errors.noise_floor]
        shown = " ".join("-" if one is None else f"{100.0 * one:.2g}" for one in told)
        cost = f"{found.cost.seconds:>8.0f}{found.cost.simulations:>8}"
        print(f"{name:<26}{cost}  {effects}; {shown} %", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
