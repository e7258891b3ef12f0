"""An FMU as a vendor delivers it, and logs of its axis as loggers write them."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping
from pathlib import Path

import asammdf
import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from gmfbo import AugmentedTwin, FmuTwin, Recording
from gmfbo.sources.fmu_file.models import models_folder

NAMES = {
    "reference": "ctl.phiRef",
    "position": "enc.phi",
    "torque_command": "ctl.tauCmd",
    "velocity": "mot.w",
    "true_position": "mot.phiTrue",
    "torque": "mot.tau",
    "tau_load": "dist.tau",
    "tau_command": "dist.tauCmd",
    "encoder_offset": "dist.enc",
    "inertia": "mech.J",
    "viscous": "mech.d",
    "kp": "ctl.Kp",
    "kd": "ctl.Kd",
}
"""Names of the vendor, by those of the servo axis."""

HIDDEN = {"coulomb_friction.level": 0.2}
"""[N.m] Physics of the real axis, of which the FMU knows nothing."""

HERTZ = (0.5, 0.9, 1.4, 2.3)
STEP = 1e-3  # [s]

Array = NDArray[np.float64]


def vendor_fmu(path: Path) -> Path:
    """Write the servo axis with the names of a vendor, and without words of ours."""
    with (
        zipfile.ZipFile(models_folder() / "servo_axis.fmu") as ours,
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as theirs,
    ):
        for name in ours.namelist():
            content = ours.read(name)
            if name == "modelDescription.xml":
                content = _renamed(content.decode()).encode()
            theirs.writestr(name, content)
    return path


def _renamed(description: str) -> str:
    for ours, theirs in NAMES.items():
        description, count = re.subn(f'name="{ours}"', f'name="{theirs}"', description)
        assert count == 1, ours
    description = re.sub(r'(<ScalarVariable [^>]*?) description="[^"]*"', r"\1", description)
    return description.replace('modelName="servo_axis"', 'modelName="AX7"')


def axis_runs(runs: int = len(HERTZ), rows: int = 2500) -> list[Recording]:
    """Runs of the real axis: sines of the reference, with noise of the encoder."""
    time: Array = np.arange(rows, dtype=np.float64) * STEP
    rng = np.random.default_rng(0)
    made = []
    with AugmentedTwin(
        FmuTwin(models_folder() / "servo_axis.toml"), substeps=10, isolated=False
    ) as axis:
        for hertz in HERTZ[:runs]:
            wave = {"reference": 0.4 * np.sin(2.0 * np.pi * hertz * time)}
            plan = axis.plan(Recording(time=time, signals=wave), {})
            noise = 3e-5 * rng.standard_normal(time.size)  # [rad]
            run = axis.run(plan, {"inertia": 0.0105}, HIDDEN, excitation={"sensor": noise})
            logged = {**wave, **run.held, "position": run.states["position"] + noise}
            made.append(Recording(time=time, signals=logged))
    return made


def in_ms_and_degrees(run: Recording) -> dict[str, Array]:
    """Columns as a drive's tool logs them, by names that state units."""
    return {
        "Time_ms": 1e3 * run.time,
        "SetPos_deg": np.rad2deg(run.signal("reference")),
        "ActPos_deg": np.rad2deg(run.signal("position")),
        "ActTorque_Nm": run.signal("torque_command"),
    }


def write_csv(path: Path, table: Mapping[str, Array]) -> Path:
    """Write columns with nine digits."""
    rows = zip(*table.values(), strict=True)
    lines = [",".join(table), *(",".join(f"{value:.9g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def write_matlab(path: Path, run: Recording) -> Path:
    """Write a structure with ms and degrees, and without any unit."""
    table = dict(
        zip(("t", "phi_soll", "phi_ist", "moment"), in_ms_and_degrees(run).values(), strict=True)
    )
    columns = {name: values.reshape(-1, 1) for name, values in table.items()}
    savemat(path, {"log": columns, "operator": "B. Meier"})
    return path


def write_mdf4(path: Path, run: Recording) -> Path:
    """Write channels in degrees, each in a group with a clock of its own."""
    _, *table = in_ms_and_degrees(run).values()
    named = (("SetPosition", "deg"), ("ActPosition", "deg"), ("TorqueCommand", "Nm"))
    with asammdf.MDF() as file:
        for (name, unit), values in zip(named, table, strict=True):
            signal = asammdf.Signal(values, run.time, name=f"Drive.{name}", unit=unit)
            file.append([signal], common_timebase=True)
        file.save(path, overwrite=True)
    return path
