"""FMUs of another maker: OpenModelica and PythonFMU3 exports that the package gemseo-fmu carries.

The package itself is not imported and none of its dependencies are needed: it wants an older fmpy
than gmfbo, so it is installed without them. Its FMUs are not part of this project.
"""

from __future__ import annotations

import importlib.metadata
import sys
from pathlib import Path

import pytest

HOW = "pip install --no-deps -c tests/constraints.txt gemseo-fmu"
_FOLDERS = {"linux": "linux", "win32": "win32"}


def find_foreign_fmu(name: str) -> Path | None:
    """Path of an FMU; None where the package is not installed, or has none for this system."""
    try:
        package = importlib.metadata.distribution("gemseo-fmu")
    except importlib.metadata.PackageNotFoundError:
        return None
    folder = _FOLDERS.get(sys.platform, "none")
    path = Path(str(package.locate_file(f"gemseo_fmu/problems/fmu_files/{folder}/{name}.fmu")))
    return path if path.is_file() else None


def foreign_fmu(name: str) -> Path:
    """Path of an FMU; the test is skipped where there is none, with how to get it."""
    path = find_foreign_fmu(name)
    if path is None:
        pytest.skip(f"no {name}.fmu for this system: {HOW} (it has FMUs for Linux and Windows)")
    return path


VENDOR_AXIS = """
name = "vendor axis"
step = 1e-3

[fmus]
controller = { kind = "pd_filtered", sample_time = 1e-3, kp = 2000.0, kd = 60.0 }
plant = "FMU"

[wires]
"plant.f" = "controller.u"
"controller.measured" = "plant.mass.s"

[inputs]
reference = "controller.reference"

[outputs]
position = "plant.mass.s"
force = "controller.u"

[parameters]                     # the spring is taken out: a sliding mass with a damper
"controller.u_min" = -200.0
"controller.u_max" = 200.0
"plant.spring.c" = 0.0
"plant.spring.s_rel0" = 0.0
"plant.fixed.s0" = 0.0
"plant.mass.L" = 0.0

[gains]
"controller.kp" = [500.0, 8000.0]
"controller.kd" = [10.0, 150.0]

[uncertain]
"plant.mass.m" = [0.5, 2.0]
"plant.damper.d" = [1.0, 40.0]

[ports]
torque = "plant.f"
sensor = "controller.measured"

[states]
position = "plant.mass.s"
velocity = "plant.mass.v"
command = "controller.u"

[roles]
inertia = "plant.mass.m"
"""
"""The shipped controller before a plant-only FMU of another maker."""

OWN_AXIS = """
name = "own axis"
step = 1e-3

[fmus]
controller = { kind = "pd_filtered", sample_time = 1e-3, kp = 2000.0, kd = 60.0 }
plant = "FMU"

[wires]
"plant.port.force" = "controller.u"
"controller.measured" = "plant.true_position"

[inputs]
reference = "controller.reference"

[outputs]
position = "plant.true_position"
force = "controller.u"

[parameters]                     # its own controller is switched off: the plant alone
"controller.u_min" = -200.0
"controller.u_max" = 200.0
"plant.kp" = 0.0
"plant.kv" = 0.0
"plant.mass" = 1.0
"plant.viscous_friction" = 10.0

[gains]
"controller.kp" = [500.0, 8000.0]
"controller.kd" = [10.0, 150.0]
"""
"""The same axis with a plant of ours."""


def write_vendor_axis(folder: Path) -> Path:
    """Twin file of the foreign plant under our controller."""
    path = folder / "vendor.toml"
    path.write_text(VENDOR_AXIS.replace("FMU", str(foreign_fmu("Mass_Damper")), 1))
    return path


def write_own_axis(folder: Path) -> Path:
    """Twin file of our plant under our controller."""
    from gmfbo.sources.fmu_file.models import models_folder

    path = folder / "own.toml"
    path.write_text(OWN_AXIS.replace("FMU", str(models_folder() / "linear_axis.fmu"), 1))
    return path
