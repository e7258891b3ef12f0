"""Makes what `gmfbo examples` copies: `python -m tests.examples.make`.

The axis that is recorded is models/demo_axis.fmu, whose laws are its own; its twin is
models/servo_axis.fmu, which has none of them. The vendor's FMU is that twin under other names.
"""

from __future__ import annotations

import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo import FmuTwin, Recording, models_folder

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "notebooks" / "examples"
SAMPLE_S = 1e-3
AXIS = {"inertia": 0.0105, "viscous": 0.05, "encoder.counts": 0.0, "encoder.noise": 3e-5}
"""The twin has an inertia of 0.01 kg m2, and 0.05 N m s/rad."""

FRICTION = {"friction.forward": 0.2, "friction.backward": 0.2}
ARM = {"arm.torque": 0.3}

VENDOR_NAMES = {
    "reference": "X7.Ctrl.PosSet",
    "tau_load": "X7.Load.TrqDist",
    "tau_command": "X7.Drive.TrqAdd",
    "encoder_offset": "X7.Enc.PosAdd",
    "inertia": "X7.Mech.J",
    "viscous": "X7.Mech.dVisc",
    "torque_lag": "X7.Drive.TCur",
    "torque_limit": "X7.Ctrl.TrqMax",
    "kp": "X7.Ctrl.Kp",
    "kd": "X7.Ctrl.Kd",
    "filter_time": "X7.Ctrl.TFilt",
    "sample_time": "X7.Ctrl.TSample",
    "initial_position": "X7.Mech.phi0",
    "position": "X7.Enc.PosAct",
    "true_position": "X7.Mech.phi",
    "velocity": "X7.Mech.w",
    "torque_command": "X7.Ctrl.TrqCmd",
    "torque": "X7.Drive.TrqAct",
}


def record(
    reference: NDArray[np.float64], parameters: Mapping[str, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Run the axis along a reference that begins at rest.

    Parameters
    ----------
    reference : ndarray of shape (rows,)
        [rad] At each sample.
    parameters : mapping of str to float
        Of models/demo_axis.fmu.

    Returns
    -------
    tuple of ndarray, each of shape (rows,)
        Position [rad] and torque command [N.m], as a logger sees them.
    """
    time = SAMPLE_S * np.arange(reference.size)
    with FmuTwin(models_folder() / "demo_axis.toml") as axis:
        asked = Recording(time=time, signals={"reference": reference})
        run = axis.run({}, asked, parameters={**AXIS, **parameters})
    assert run.status == "ok", run.message
    return run.signals["position"], run.signals["torque_command"]


def sine(hertz: float, seconds: float = 1.5) -> NDArray[np.float64]:
    """[rad] Sine of 0.4 rad."""
    return 0.4 * np.sin(2.0 * np.pi * hertz * SAMPLE_S * np.arange(round(seconds / SAMPLE_S)))


def servo_log(reference: NDArray[np.float64], seed: int) -> str:
    """Text of a log in SI, of the axis with friction."""
    position, torque = record(reference, {**FRICTION, "encoder.seed": seed})
    lines = ["time [s],reference [rad],position [rad],torque_command [N.m]"]
    lines += [
        f"{SAMPLE_S * k:.3f},{wanted:.7f},{read:.7f},{command:.6f}"
        for k, (wanted, read, command) in enumerate(zip(reference, position, torque, strict=True))
    ]
    return "\n".join(lines) + "\n"


def vendor_log(reference: NDArray[np.float64], seed: int) -> str:
    """Text of a log in milliseconds and degrees, of the axis with an unbalanced arm."""
    position, torque = record(reference, {**ARM, "encoder.seed": seed})
    lines = ["t [ms];PosSet [deg];PosAct [deg];TrqCmd [N.m]"]
    lines += [
        f"{k};{wanted:.5f};{read:.5f};{command:.6f}"
        for k, (wanted, read, command) in enumerate(
            zip(np.degrees(reference), np.degrees(position), torque, strict=True)
        )
    ]
    return "\n".join(lines) + "\n"


def vendor_fmu() -> dict[str, bytes]:
    """Members of models/servo_axis.fmu, with a vendor's names in the model description."""
    with zipfile.ZipFile(models_folder() / "servo_axis.fmu") as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    text = members["modelDescription.xml"].decode()
    for ours, theirs in VENDOR_NAMES.items():
        before = f'<ScalarVariable name="{ours}" '
        assert text.count(before) == 1
        text = text.replace(before, f'<ScalarVariable name="{theirs}" ')
    for ours in ("tau_load", "encoder_offset"):  # also in descriptions
        text = text.replace(ours, VENDOR_NAMES[ours])
    text = text.replace('modelName="servo_axis"', 'modelName="X7"')
    text = text.replace('generationTool="gmfbo"', 'generationTool="a vendor\'s tool"')
    members["modelDescription.xml"] = text.encode()
    return members


def write_zip(members: Mapping[str, bytes], path: Path) -> None:
    """Write an archive that is the same each time."""
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in sorted(members.items()):
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED, compresslevel=9)


def write_logs(folder: Path) -> None:
    """Write the recordings of both rigs."""
    for number, hertz in enumerate((0.5, 0.9, 1.4, 2.3)):
        log = servo_log(sine(hertz), seed=number)
        (folder / f"run{number}.csv").write_text(log, encoding="utf-8")
    for number, hertz in enumerate((0.6, 1.3)):
        log = vendor_log(sine(hertz), seed=10 + number)
        (folder / "vendor" / f"log{number}.csv").write_text(log, encoding="utf-8")


if __name__ == "__main__":
    write_logs(EXAMPLES)
    write_zip(vendor_fmu(), EXAMPLES / "vendor" / "x7.fmu")
    sys.exit(0)
