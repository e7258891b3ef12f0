"""Makes what `gmfbo examples` copies: `python -m tests.examples.make`.

With the `next.csv` of `gmfbo experiment` it writes `played.csv` alone.

The servo's recordings are those of its twin with friction. The vendor's FMU is
models/servo_axis.fmu under other names; models/demo_axis.fmu, whose laws are its own, plays the
vendor's rig.
"""

from __future__ import annotations

import sys
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo import AugmentedTwin, FmuTwin, Recording, models_folder

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "notebooks" / "examples"
SAMPLE_S = 1e-3
FRICTION = {"coulomb_friction.level": 0.2}
"""[N m] Of the axis of the servo's recordings, whose inertia is 0.0105 kg m2 and not 0.01."""

ARM = {"inertia": 0.0105, "arm.torque": 0.3, "encoder.noise": 3e-5}
"""Of the vendor's rig: an unbalanced mass [N m] that its FMU does not have."""

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


def clock(rows: int) -> NDArray[np.float64]:
    """[s] Time of each row."""
    return SAMPLE_S * np.arange(rows, dtype=np.float64)


def sine(hertz: float, seconds: float) -> NDArray[np.float64]:
    """[rad] Sine of 0.4 rad."""
    return np.asarray(0.4 * np.sin(2.0 * np.pi * hertz * clock(round(seconds / SAMPLE_S))))


def servo_runs(hidden: Mapping[str, float] = FRICTION) -> list[NDArray[np.float64]]:
    """Record four sines of the servo axis with physics that its twin lacks.

    Parameters
    ----------
    hidden : mapping of str to float
        Sizes of effects.

    Returns
    -------
    list of ndarray of shape (2500, 4)
        Time [s], reference [rad], position [rad] and torque command [N.m] of each.
    """
    rng = np.random.default_rng(0)
    tables = []
    with AugmentedTwin(FmuTwin(models_folder() / "servo_axis.toml"), substeps=10) as axis:
        for hertz in (0.5, 0.9, 1.4, 2.3):
            wave = sine(hertz, 2.5)
            time = clock(wave.size)
            plan = axis.plan(Recording(time=time, signals={"reference": wave}), {})
            noise = 3e-5 * rng.standard_normal(time.size)  # [rad] the controller reads it too
            run = axis.run(plan, {"inertia": 0.0105}, hidden, excitation={"sensor": noise})
            position = run.states["position"] + noise
            tables.append(np.column_stack([time, wave, position, run.held["torque_command"]]))
    return tables


def vendor_run(
    reference: NDArray[np.float64], seed: int, parameters: Mapping[str, float] = ARM
) -> NDArray[np.float64]:
    """Record the vendor's rig, which is models/demo_axis.fmu, along a reference.

    Parameters
    ----------
    reference : ndarray of shape (rows,)
        [rad] At each sample; it begins at rest.
    seed : int
        Of the encoder's noise.
    parameters : mapping of str to float
        Of the FMU.

    Returns
    -------
    ndarray of shape (rows, 4)
        Time [ms], reference [deg], position [deg] and torque command [N.m].
    """
    time = clock(reference.size)
    with FmuTwin(models_folder() / "demo_axis.toml") as axis:
        asked = Recording(time=time, signals={"reference": reference})
        run = axis.run({}, asked, parameters={**parameters, "encoder.seed": float(seed)})
    assert run.status == "ok", run.message
    angles = np.degrees([reference, run.signals["position"]])
    return np.column_stack([1e3 * time, *angles, run.signals["torque_command"]])


def vendor_runs() -> list[NDArray[np.float64]]:
    """Two sines of the vendor's rig, each as `vendor_run` returns it."""
    return [vendor_run(sine(hertz, 1.5), 10 + k) for k, hertz in enumerate((0.6, 1.3))]


def text(table: NDArray[np.float64], header: str, between: str, digits: Sequence[int]) -> str:
    """Write a log: a header, and rows with so many digits behind the point a column."""
    rows = [
        between.join(f"{value:.{count}f}" for value, count in zip(row, digits, strict=True))
        for row in table
    ]
    return "\n".join([header, *rows]) + "\n"


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


def write_servo_runs(folder: Path) -> None:
    """Write the recordings of the servo."""
    header = "time [s],reference [rad],position [rad],torque_command [N.m]"
    for number, table in enumerate(servo_runs()):
        rows = text(table, header, ",", (3, 9, 9, 9))
        (folder / f"run{number}.csv").write_text(rows, encoding="utf-8")


def write_vendor_run(table: NDArray[np.float64], path: Path) -> None:
    """Write a log of the vendor's rig."""
    header = "t [ms];PosSet [deg];PosAct [deg];TrqCmd [N.m]"
    path.write_text(text(table, header, ";", (0, 5, 5, 6)), encoding="utf-8")


def play(asked: Path) -> NDArray[np.float64]:
    """Play a reference that `gmfbo experiment` wrote on the vendor's rig."""
    return vendor_run(Recording.read(asked).signals["reference"], 20)


if __name__ == "__main__":
    vendor = EXAMPLES / "vendor"
    if sys.argv[1:]:
        write_vendor_run(play(Path(sys.argv[1])), vendor / "played.csv")
    else:
        write_servo_runs(EXAMPLES)
        for k, run in enumerate(vendor_runs()):
            write_vendor_run(run, vendor / f"log{k}.csv")
        write_zip(vendor_fmu(), vendor / "x7.fmu")
