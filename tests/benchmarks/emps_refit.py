"""Refit mass and viscous friction of the EMPS twin on the first half, score the second.

    GMFBO_DATA=FOLDER python tests/benchmarks/emps_refit.py \\
        > tests/benchmarks/results/emps_refit/emps_refit.txt

The twin has no Coulomb friction, so the refit viscous friction swallows part of it: the fit
improves in both signals while a structural error stays in the drive input.

Source of the recording and of the published values: Janot, Gautier, Brunot (2019), "Data set
and reference models of EMPS".
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from gmfbo import FmuTwin, Recording
from gmfbo.objective.fit import compare_at
from gmfbo.sources.fmu_file.models import models_folder

SIGNALS = ("position", "drive_voltage")
PUBLISHED = {"mass": 95.1089, "viscous_friction": 203.5034}


def main() -> int:
    """Print the errors of the published and the refitted twin on the unseen half."""
    if "GMFBO_DATA" not in os.environ:
        print("set GMFBO_DATA to the folder that holds emps/DATA_EMPS.mat", file=sys.stderr)
        return 2
    with FmuTwin(models_folder() / "emps.toml") as twin:
        recording = Recording.read(Path(os.environ["GMFBO_DATA"]) / "emps/DATA_EMPS.mat", twin)
        middle = 0.5 * (recording.time[0] + recording.time[-1])
        fitted = refit(twin, recording, middle)
        for label, values in (("published", PUBLISHED), ("refitted", fitted)):
            mass, friction = values["mass"], values["viscous_friction"]
            print(f"{label:<10} M = {mass:8.3f} kg, Fv = {friction:8.3f} N s/m")
        heads = ("NRMSE published", "NRMSE refitted", "relative 2-norm")
        print(f"{'second half':<16}" + "".join(f"{head:>18}" for head in heads))
        for signal in SIGNALS:
            before = scored(twin, recording, PUBLISHED, signal, middle)
            after = scored(twin, recording, fitted, signal, middle)
            print(f"{signal:<16}{before[0]:>17.4%} {after[0]:>17.4%} {after[1]:>17.3%}")
    return 0


def refit(twin: FmuTwin, recording: Recording, until: float) -> dict[str, float]:
    """Least squares on the first half, each signal over its range."""
    first = recording.time <= until
    scale = {s: float(np.ptp(recording.signal(s)[first])) for s in SIGNALS}

    def residuals(share: NDArray[np.float64]) -> NDArray[np.float64]:
        trajectory = twin.run({}, recording, parameters=named(share))
        return np.concatenate(
            [compare_at(trajectory, recording, s)[first] / scale[s] for s in SIGNALS]
        )

    # A difference step of 2e-3 sees through encoder quantisation, 1e-8 does not.
    start = np.ones(len(PUBLISHED))
    solution = least_squares(residuals, start, diff_step=np.full(len(start), 2e-3))
    return named(solution.x)


def named(share: NDArray[np.float64]) -> dict[str, float]:
    """Parameters from their share of the published value."""
    return {
        name: float(s) * value for s, (name, value) in zip(share, PUBLISHED.items(), strict=True)
    }


def scored(
    twin: FmuTwin, recording: Recording, parameters: dict[str, float], signal: str, after: float
) -> tuple[float, float]:
    """NRMSE and relative 2-norm of one signal after a time."""
    trajectory = twin.run({}, recording, parameters=parameters)
    second = recording.time > after
    residual = compare_at(trajectory, recording, signal)[second]
    measured = recording.signal(signal)[second]
    relative = float(np.linalg.norm(residual) / np.linalg.norm(measured))
    return float(np.sqrt(np.mean(residual**2)) / np.ptp(measured)), relative


if __name__ == "__main__":
    sys.exit(main())
