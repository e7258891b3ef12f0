"""What a diagnosis says of real axes of laboratories, of which nobody here knows what is missing.

    python -m tests.benchmarks.lab_motors FOLDER > lab_motors.txt

FOLDER holds files of public repositories, or their first rows, under the names in `RIGS`. Each twin
is `motor_bench.fmu`, open loop, driven by the recorded voltage, current or torque; the back-EMF of
a motor on a voltage is viscous friction.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gmfbo import FmuTwin, Recording, diagnose, models_folder
from tests.benchmarks.plain_rigs import WHERE

TWIN = """name = "laboratory axis"
fmu = "{models}/motor_bench.fmu"
step = 1e-3
[inputs]
current = "current"
[outputs]
{output} = "{output}"
[parameters]
inertia = {inertia[1]}
viscous = {viscous[1]}
torque_constant = {constant}
[initial]
{initial}
[uncertain]
inertia = [{inertia[0]}, {inertia[2]}]
viscous = [{viscous[0]}, {viscous[2]}]
"""
DEGREE = float(np.pi / 180.0)
UNMOTOR = (0.002, 0.008, 0.02), (0.05, 0.2, 0.5)


@dataclass(frozen=True)
class Rig:
    """A recording, and the twin of its axis.

    Attributes
    ----------
    source : str
        Repository and path of the file.
    columns : tuple of str
        Time, input and output in its header.
    inertia, viscous : tuple of float
        [kg m2], [N m s/rad] Least, as the twin has it, largest.
    output : str
        `position` or `velocity`.
    factors : tuple of float
        From the file's units to s, A (or what stands for it) and rad.
    constant : float
        [N m/A]
    initial : mapping of str to str
        Starts of the twin file.
    seconds : float
        That are read.
    """

    source: str
    columns: tuple[str, str, str]
    inertia: tuple[float, float, float]
    viscous: tuple[float, float, float]
    output: str = "position"
    factors: tuple[float, float, float] = (1.0, 1.0, 1.0)
    constant: float = 0.5
    initial: dict[str, str] = field(default_factory=dict)
    seconds: float = 9.13


RIGS = {
    "turning_one_way": Rig(
        "nebisman/DCMotor.jl, datafiles/DCmotor_prbs_open_exp.csv",
        ("t", "u", "y"),
        *UNMOTOR,
        output="velocity",
        factors=(1.0, 1.0, DEGREE),
    ),
    "to_and_back": Rig(
        "nebisman/DCMotor.jl, datafiles/DCmotor_profile_closed_exp.csv",
        ("t", "u", "y"),
        *UNMOTOR,
        factors=(1.0, 1.0, DEGREE),
    ),
    "two_turns": Rig(
        "nebisman/UNDCMotor, code/python_code/unmotor/datafiles/DCmotor_profile_closed_exp.csv",
        ("t", "u", "y"),
        (0.002, 0.01, 0.02),
        (0.01, 0.2, 0.5),
        factors=(1.0, 1.0, DEGREE),
    ),
    "screw_sweep": Rig(
        "nicolazande/camber-control, actuators/LinA/data/no-pp-sine-sweep-10mm-0.5Hz.txt",
        ("time_ms", "current_mA", "actual_position_mm"),
        (8e-7, 1.63e-6, 1e-5),
        (0.0, 7.8e-6, 1e-4),
        factors=(1e-3, 1e-3, 22.405),
        constant=0.0429,
    ),
    "screw_square": Rig(
        "nicolazande/camber-control, actuators/LinD/data/no-pp-square-wave-10mm-1Hz.txt",
        ("time_ms", "current_mA", "actual_position_mm"),
        (1e-5, 1.83e-5, 1e-4),
        (0.0, 7.1e-5, 1e-3),
        factors=(1e-3, 1e-3, 6.669),
        constant=0.0706,
    ),
    "potentiometer": Rig(
        "gkeiel/dc_motor_position_control, dc_motor_position_control_pid_step/data.csv",
        ("time_s", "control_percent", "position_deg"),
        (0.01, 0.03, 0.5),
        (0.03, 0.3, 3.0),
        constant=1.0,
        initial={"initial_position": '"position"', "initial_velocity": '"fit"'},
    ),
    "pendulum": Rig(
        "dfki-ric-underactuated-lab/torque_limited_simple_pendulum, "
        "results/20210706-041704-PM_energy_shaping/data_measured.csv",
        ("time_s", "torque_measured_Nm", "position_rad"),
        (0.05, 0.14, 0.4),
        (0.0, 0.05, 0.5),
        constant=1.0,
    ),
    "wheel": Rig(
        "frodibrooks/Jack, log_motor_0.txt",
        ("time_s", "motor_voltage_V", "velocity_m_s"),
        (0.05, 0.6, 3.0),
        (1.0, 6.0, 20.0),
        output="velocity",
        constant=1.0,
    ),
}
"""By name of the file, without its `.csv`.

The potentiometer's axis is in degrees and per cent, the wheel in metres and volts.
"""


def recording(path: Path, rig: Rig) -> Recording:
    """Read one of the files.

    Parameters
    ----------
    path : Path
        The file.
    rig : Rig
        Which columns are read, and their units.
    """
    columns = np.genfromtxt(path, delimiter=",", names=True)
    time, driven, shown = (
        factor * columns[name] for name, factor in zip(rig.columns, rig.factors, strict=True)
    )
    time = time - time[0]
    rows = time < rig.seconds
    signals = {"current": driven[rows], rig.output: shown[rows]}
    return Recording(time=time[rows], signals=signals, name=path.name)


def twin_file(rig: Rig) -> str:
    """Text of a rig's twin file."""
    values = {name: getattr(rig, name) for name in ("output", "inertia", "viscous", "constant")}
    initial = "\n".join(f"{name} = {value}" for name, value in rig.initial.items())
    return TWIN.format(models=models_folder(), initial=initial, **values) + WHERE.format(m="")


def main(folder: Path) -> None:
    """Diagnose each file that is there."""
    for name, rig in RIGS.items():
        file = folder / f"{name}.csv"
        if not file.is_file():
            continue
        with tempfile.TemporaryDirectory() as made:
            path = Path(made) / "axis.toml"
            path.write_text(twin_file(rig), encoding="utf-8")
            with FmuTwin(path) as twin:
                found = diagnose(twin, [recording(file, rig)], seed=0)
        print(f"{name}: {rig.source}\n{found!r}")
        print(f"{found.cost.simulations} simulations, {found.cost.seconds:.0f} s")
        for note in found.notes:
            print(f"note: {note}")
        print(flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
