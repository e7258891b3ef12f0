"""Runs of the drive FMUs with all their inputs and outputs, through the twin driver."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from gmfbo import FmuTwin, Recording, Trajectory
from gmfbo.sources.fmu_file.models import models_folder

INPUTS = (
    "reference",
    "velocity_reference",
    "torque_reference",
    "tau_load",
    "tau_command_offset",
    "encoder_offset",
    "motor_encoder_offset",
)
OUTPUTS = (
    "torque_command",
    "position",
    "motor_position",
    "true_position",
    "true_motor_position",
    "velocity",
    "motor_velocity",
    "torque",
    "i_d",
    "i_q",
    "v_d",
    "v_q",
)
IDEAL_ENCODERS = {"enc.resolution": 0.0, "enc.motor_resolution": 0.0}
NO_FRICTION = {"friction.scale": 0.0}
NO_RIPPLE = {"cogging.amplitude[1]": 0.0, "cogging.amplitude[2]": 0.0, "ripple.amplitude": 0.0}
CORNERS = ((30.0, 2.0), (30.0, 10.0), (200.0, 2.0), (200.0, 10.0))
"""Corners of the box of gains [N.m/rad, N.m.s/rad]."""


@dataclass(frozen=True)
class Drive:
    """The drive twin with every input and output named as in the FMU."""

    folder: Path

    def run(
        self,
        parameters: Mapping[str, float] | None = None,
        *,
        gains: tuple[float, float] = (100.0, 6.0),
        duration: float = 1.1,
        step: float = 1e-3,
        schedules: Mapping[str, ArrayLike] | None = None,
        **inputs: ArrayLike,
    ) -> Trajectory:
        """Simulate; inputs are constants or one value a row, the reference a step at 0.1 s."""
        rows = round(duration / step) + 1
        time = np.arange(rows, dtype=np.float64) * np.float64(step)
        driven = {"reference": np.where(time > 0.1 - 0.5 * step, 1.0, 0.0), **inputs}
        recording = Recording(
            time=time,
            signals={name: np.broadcast_to(value, rows) for name, value in driven.items()},
            schedules={name: np.asarray(value) for name, value in (schedules or {}).items()},
        )
        with FmuTwin(self.twin_file(), isolated=False, step=step) as twin:
            run = twin.run(
                {"ctl.Kp": gains[0], "ctl.Kd": gains[1]}, recording, parameters=parameters
            )
        assert run.status == "ok", run.message
        return run

    def twin_file(self) -> Path:
        """Twin file that names everything; written once."""
        path = self.folder / "everything.toml"
        if not path.exists():
            fmu = (models_folder() / "drive_twin.fmu").as_posix()
            lines = ['name = "drive"', f"fmu = {json.dumps(fmu)}", "step = 1e-3", "[inputs]"]
            lines += [f'{name} = "{name}"' for name in INPUTS]
            lines += ["[outputs]", *(f'{name} = "{name}"' for name in OUTPUTS)]
            lines += ["[initial]", '"initial.position" = 0.0']
            lines += ["[gains]", '"ctl.Kp" = [0.0, 2000.0]', '"ctl.Kd" = [0.0, 200.0]']
            path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return path
