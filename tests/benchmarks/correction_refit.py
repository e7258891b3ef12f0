"""Refit of the trajectory correction: time and held-out error against the exact process.

Axis = drive twin, twin = the same with 50 % noise in its flux map, recorded every 0.5 ms. The even
rows (n = 1101, 1 kHz) train; what is held out is read in three ways, none of them trained on:

true        odd rows against the axis' true position, which its encoder rounds to 1.5e-3 rad
new gains   odd rows of a run at gains nearby, which is what the correction is for
encoder     odd rows against the encoder. The exact process drives its noise to the floor and
            follows the encoder's steps from one row to the next; it gains on this reading what
            it does not gain on the truth. Shown, and not held to the limit.

Limits: 0.5 s for the fit, and errors, pooled over the gains, within 3 % of the exact process'.

    python tests/benchmarks/correction_refit.py
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo import FmuTwin, Recording, step_reference
from gmfbo.correction.trajectory_gp import CorrectionSettings, Pair, TrajectoryCorrection
from gmfbo.sources.fmu_file.models import models_folder

RESULT = Path(__file__).parent / "results" / "correction_refit" / "correction_refit.txt"
GAINS = ((100.0, 5.0), (180.0, 7.0), (60.0, 3.0))
NEARBY = (6.0, 0.3)
LIMIT_S, LIMIT_RATIO = 0.5, 1.03
REPEATS = 3
READINGS = ("true", "new gains", "encoder")
TRAINED, HELD_OUT = slice(0, None, 2), slice(1, None, 2)
TWIN = {"map.noise": 0.5, "map.seed": 1.0}


def twin_file(folder: Path) -> Path:
    """Twin file of the drive that also reads the true position."""
    text = (models_folder() / "drive_twin.toml").read_text(encoding="utf-8")
    text = text.replace("[outputs]\n", '[outputs]\ntruth = "true_position"\n')
    fmu = (models_folder() / "drive_twin.fmu").as_posix()
    text = text.replace('fmu = "drive_twin.fmu"', f"fmu = '{fmu}'")
    file = folder / "drive.toml"
    file.write_text(text, encoding="utf-8")
    return file


def run(file: Path, gains: tuple[float, float], parameters: dict[str, float]) -> Recording:
    """Unit step every 0.5 ms."""
    with FmuTwin(file, step=5e-4, parameters=parameters) as twin:
        return twin.run(gains, step_reference(sample_time=5e-4))


def errors(correction: TrajectoryCorrection, runs: list[Recording]) -> NDArray[np.float64]:
    """RMS error [rad] by reading; runs are of twin and axis here, and at the gains nearby."""
    twin, axis, near_twin, near_axis = runs
    clock = twin.time[HELD_OUT]
    here, _ = correction.correct(clock, twin.signal("position")[HELD_OUT])
    near, _ = correction.correct(clock, near_twin.signal("position")[HELD_OUT])
    differences = [
        here - axis.signal("truth")[HELD_OUT],
        near - near_axis.signal("position")[HELD_OUT],
        here - axis.signal("position")[HELD_OUT],
    ]
    return np.array([np.sqrt(np.mean(d**2)) for d in differences])


def fastest(
    pair: Pair, settings: CorrectionSettings, repeats: int
) -> tuple[float, TrajectoryCorrection]:
    """Least time of a fit [s], and the fit."""
    seconds = []
    for _ in range(repeats):
        begin = time.perf_counter()
        correction = TrajectoryCorrection.fit([pair], settings)
        seconds.append(time.perf_counter() - begin)
    return min(seconds), correction


def main() -> int:
    """Measure all gains, write the table, and return 1 where a limit is broken."""
    lines = ["$ python tests/benchmarks/correction_refit.py"]
    lines.append(f"{'gains':12}{'fit':8}{'[s]':>8}" + "".join(f"{r:>12}" for r in READINGS))
    slowest, squares = 0.0, {"thinned": np.zeros(3), "exact": np.zeros(3)}
    with tempfile.TemporaryDirectory() as folder:
        file = twin_file(Path(folder))
        for gains in GAINS:
            near = (gains[0] + NEARBY[0], gains[1] + NEARBY[1])
            runs = [run(file, at, with_) for at in (gains, near) for with_ in (TWIN, {})]
            pair = Pair(
                runs[0].time[TRAINED],
                runs[0].signal("position")[TRAINED],
                runs[1].signal("position")[TRAINED],
            )
            for name, exact, repeats in (("thinned", False, REPEATS), ("exact", True, 1)):
                seconds, fit = fastest(pair, CorrectionSettings(exact=exact), repeats)
                rms = errors(fit, runs)
                squares[name] += rms**2
                slowest = slowest if exact else max(slowest, seconds)
                label = f"{gains[0]:g}, {gains[1]:g}"
                lines.append(
                    f"{label:12}{name:8}{seconds:8.2f}" + "".join(f"{e:12.3e}" for e in rms)
                )
    ratios = np.sqrt(squares["thinned"] / squares["exact"])
    lines.append(f"{'pooled':12}{'ratio':8}{'':8}" + "".join(f"{r:12.3f}" for r in ratios))
    kept = slowest <= LIMIT_S and bool(np.all(ratios[:2] <= LIMIT_RATIO))
    lines.append(
        f"limits: fit {LIMIT_S} s (slowest {slowest:.2f} s), ratio {LIMIT_RATIO} for "
        f"{READINGS[0]} and {READINGS[1]}: {'kept' if kept else 'broken'}"
    )
    text = "\n".join(lines) + "\n"
    print(text, end="")
    RESULT.write_text(text, encoding="utf-8")
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
