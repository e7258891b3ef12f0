"""Text of a twin file: a motor under a PD controller, two FMUs that are wired."""

from __future__ import annotations

from tests.diagnosis.servo_recordings import MODELS

BENCH = f"""
name = "motor under a PD controller"
step = 1e-3
[fmus]
controller = {{ kind = "pd_filtered", kp = 10.0, kd = 0.3 }}
plant = "{MODELS / "motor_bench.fmu"}"
[wires]
"plant.current" = "controller.u"
"controller.measured" = "plant.position"
[inputs]
reference = "controller.reference"
[outputs]
position = "plant.position"
current = "controller.u"
[ports]
torque = "plant.tau_load"
sensor = "controller.measured"
[states]
position = "plant.position"
velocity = "plant.velocity"
command = "controller.u"
[roles]
inertia = "plant.inertia"
"""
