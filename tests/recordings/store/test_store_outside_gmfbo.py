"""Others work with a study by h5py and gpytorch alone."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from gmfbo.recordings import Trajectory, Trial
from gmfbo.recordings.store.pack import pack_study
from gmfbo.recordings.store.study_folder import StudyStore

PROGRAM = Path(__file__).with_name("correction_outside_gmfbo.py")


def axis_run(kp: float, kd: float, *, inertia: float, friction: float) -> Trajectory:
    """Step of 1 rad at 0.1 s on J q'' = Kp (r - q) - Kd q' - b q', by SciPy."""
    time = 1e-3 * np.arange(1101, dtype=np.float64)

    def slope(t: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        reference = 1.0 if t >= 0.1 else 0.0
        position, speed = state
        torque = kp * (reference - position) - (kd + friction) * speed
        return np.array([speed, torque / inertia])

    solved = solve_ivp(slope, (0.0, 1.1), (0.0, 0.0), t_eval=time, max_step=2e-3, rtol=1e-8)
    return Trajectory(time=time, signals={"position": solved.y[0]}, units={"position": "rad"})


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Study of two pairs: the axis (IS1) is heavier and rubs more than its twin (IS2)."""
    folder = tmp_path_factory.mktemp("outside") / "axis.study"
    with StudyStore.create(folder, "") as store:
        for number, (kp, kd) in ((1, (90.0, 4.0)), (3, (96.0, 4.2))):
            gains = {"ctl.Kp": kp, "ctl.Kd": kd}
            axis = axis_run(kp, kd, inertia=0.14, friction=1.0)
            twin = axis_run(kp, kd, inertia=0.12, friction=0.5)
            store.write_trial(Trial(number, "IS1", gains, axis, objective=0.0, metrics={}))
            store.write_trial(
                Trial(number + 1, "IS2", gains, twin, objective=0.0, metrics={}, parent=number)
            )
    return folder


@pytest.mark.parametrize("packed", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_correction_is_trained_from_the_store_without_gmfbo(
    folder: Path, tmp_path: Path, packed: bool
) -> None:
    path = pack_study(folder, tmp_path / "axis.h5") if packed else folder / "index.h5"
    done = subprocess.run(
        [sys.executable, str(PROGRAM), str(path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    uncorrected, corrected = map(float, done.stdout.split())
    assert uncorrected > 0.01
    assert corrected < 0.5 * uncorrected
