"""How the shaft answers a push says whether a loop holds it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording, models_folder
from gmfbo.diagnosis.checking.check import check

TWIN = """
name = "motor on a small drive"
step = 2e-3

[fmus]
controller = "{models}/pd_filtered.fmu"
motor = "{models}/motor_bench.fmu"

[wires]
"controller.measured" = "motor.position"
"motor.current" = "controller.u"

[inputs]
reference = "controller.reference"

[outputs]
position = "motor.position"
command = {{ variable = "controller.u", logged = "new" }}

[parameters]
"controller.kp" = 160.0
"controller.kd" = 4.0
"controller.filter_time" = 0.05
"controller.sample_time" = 2e-3
"controller.u_min" = -200.0
"controller.u_max" = 200.0
"motor.torque_constant" = 1e-3
"motor.inertia" = 5.7e-4
"motor.viscous" = 7e-3

[uncertain]
"motor.inertia" = [1e-4, 2e-3]

[gains]
"controller.kp" = [50.0, 400.0]

[ports]
torque = "motor.tau_load"
command = "motor.current"

[states]
position = "motor.position"
velocity = "motor.velocity"
command = "controller.u"

[roles]
inertia = "motor.inertia"
"""


@pytest.mark.parametrize("is_wired", [True, False])
def test_a_push_beyond_the_drives_limit_is_no_proof_of_an_open_loop(
    tmp_path: Path, is_wired: bool
) -> None:
    """Where a command is large in amperes, 5 % of it is far more than the motor's torque."""
    text = TWIN.format(models=models_folder().as_posix())
    if not is_wired:
        text = text.replace('"controller.measured" = "motor.position"\n', "")
    (path := tmp_path / "twin.toml").write_text(text, encoding="utf-8")
    clock = np.arange(1000, dtype=np.float64) * 2e-3
    motion = {"reference": 0.5 * np.sin(2.0 * np.pi * 1.5 * clock)}
    with FmuTwin(path) as twin:
        run = twin.run({}, Recording(time=clock, signals=motion))
        seen = motion | {name: run.signal(name) for name in ("position", "command")}
        checked = check(twin, [Recording(time=clock, signals=seen, name="rec.csv")])
    assert any("open-loop plant" in note for note in checked.notes) != is_wired
