"""What a diagnosis says of two real laboratory motors, recorded in rows of 20 ms.

    python -m tests.benchmarks.lab_motors FOLDER > lab_motors.txt

FOLDER holds files of two public repositories under these names:

- `turning_one_way.csv`: nebisman/DCMotor.jl, datafiles/DCmotor_prbs_open_exp.csv
- `to_and_back.csv`: the same, datafiles/DCmotor_profile_closed_exp.csv
- `two_turns.csv`: nebisman/UNDCMotor,
  code/python_code/unmotor/datafiles/DCmotor_profile_closed_exp.csv

Their columns are t [s], r [deg], y [deg/s or deg] and u [V]. The twin is `motor_bench.fmu` with the
voltage as its current, so that 0.5 N m stand for a volt, and the back-EMF is viscous friction. What
these twins lack is not known.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from gmfbo import FmuTwin, Recording, diagnose, models_folder
from tests.benchmarks.plain_rigs import WHERE

SECONDS = 9.13  # of the longest recording
TWIN = """name = "laboratory motor"
fmu = "{models}/motor_bench.fmu"
step = 1e-3
[inputs]
current = "current"
[outputs]
{output} = "{output}"
[parameters]
inertia = {inertia}
viscous = 0.2
[uncertain]
inertia = [0.002, 0.02]
viscous = [{least}, 0.5]
""" + WHERE.format(m="")
RIGS = {
    "turning_one_way": ("velocity", 0.008, 0.05),
    "to_and_back": ("position", 0.008, 0.05),
    "two_turns": ("position", 0.01, 0.01),
}
"""Output, inertia [kg m2] and least viscous friction [N m s/rad] of each twin."""


def recording(path: Path, output: str) -> Recording:
    """Read one of the files.

    Parameters
    ----------
    path : Path
        The file.
    output : str
        What its column y is.
    """
    columns = np.genfromtxt(path, delimiter=",", names=True)
    rows = columns["t"] < SECONDS
    signals = {"current": columns["u"][rows], output: np.deg2rad(columns["y"][rows])}
    return Recording(time=columns["t"][rows], signals=signals, name=path.name)


def main(folder: Path) -> None:
    """Diagnose each file that is there."""
    for name, (output, inertia, least) in RIGS.items():
        twin_file = TWIN.format(models=models_folder(), output=output, inertia=inertia, least=least)
        with tempfile.TemporaryDirectory() as made:
            path = Path(made) / "motor.toml"
            path.write_text(twin_file, encoding="utf-8")
            with FmuTwin(path) as twin:
                found = diagnose(twin, [recording(folder / f"{name}.csv", output)], seed=0)
        print(f"{name}\n{found!r}")
        print(f"{found.cost.simulations} simulations, {found.cost.seconds:.0f} s")
        for note in found.notes:
            print(f"note: {note}")
        print(flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
