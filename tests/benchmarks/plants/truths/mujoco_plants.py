"""Two plants in MuJoCo: an arm that has weight and friction, and a belt axis that gives way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from gmfbo.recordings.recording import Recording
from tests.benchmarks.plants.truths.conditions import Conditions, Fallen, Vector
from tests.benchmarks.plants.truths.laws import Pid

SAMPLE, STEPS = 1e-3, 4
COUNT = 2.0 * math.pi / 65536
"""[rad] Of both encoders."""

ARM = """<mujoco>
  <option timestep="2.5e-4" integrator="implicitfast" gravity="0 0 -9.80665"/>
  <worldbody>
    <body>
      <joint name="motor" type="hinge" axis="0 1 0" damping="0.16" frictionloss="0.9"
             armature="0.02"/>
      <inertial pos="0.16 0 0" mass="1.6" diaginertia="0.004 0.004 0.004"/>
    </body>
  </worldbody>
  <actuator>
    <general joint="motor" dyntype="filterexact" dynprm="1.5e-3" gainprm="0.8"/>
  </actuator>
</mujoco>"""
"""The arm lies level, its weight of 2.5 N m pulls towards positive angles."""

BELT = """<mujoco>
  <option timestep="2.5e-4" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody>
    <body name="pulley">
      <joint name="motor" type="hinge" axis="0 0 1" damping="0.02" frictionloss="0.25"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.0022 0.0022 0.0022"/>
      <body name="sled">
        <joint name="belt" type="hinge" axis="0 0 1" stiffness="420" damping="0.12"/>
        <inertial pos="0 0 0" mass="1" diaginertia="0.003 0.003 0.003"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <general joint="motor" dyntype="filterexact" dynprm="8e-4" gainprm="0.4"/>
  </actuator>
</mujoco>"""
"""The sled's inertia at the pulley is 0.003 kg m2, behind a belt of 420 N m/rad."""


@cache
def _model(text: str) -> Any:
    import mujoco

    return mujoco.MjModel.from_xml_string(text)


def _play(
    text: str,
    law: Pid,
    reference: Recording,
    conditions: Conditions,
    *,
    delay: int,
    deviation: float,
) -> dict[str, Vector]:
    import mujoco

    model: Any = _model(text)
    data: Any = mujoco.MjData(model)
    level = float(model.dof_frictionloss[0])
    moved = [
        (part, part.copy()) for part in (model.body_mass, model.body_inertia, model.dof_armature)
    ]
    wanted = reference.signal("reference")
    noise, out = conditions.noise(deviation, len(wanted)), np.empty((2, len(wanted)))
    command, waiting = 0.0, [0.0] * delay
    model.dof_frictionloss[0] = conditions.friction * level
    for part, mean in moved:
        part[:] = conditions.inertia * mean
    mujoco.mj_setConst(model, data)
    try:
        for k, target in enumerate(wanted.tolist()):
            reading = COUNT * math.floor((float(data.qpos[0]) + noise[k]) / COUNT + 0.5)
            out[:, k] = reading, command
            command = law.next(target, reading)
            waiting.append(command)
            data.ctrl[0] = waiting.pop(0)
            mujoco.mj_step(model, data, STEPS)
            if not abs(data.qvel[0]) < 1e4:
                raise Fallen("the motor races")
    finally:
        model.dof_frictionloss[0] = level
        for part, mean in moved:
            part[:] = mean
    named = {"position": out[0], "current": out[1]}
    return {"time": reference.time, "reference": wanted, **named}


def _law(gains: Mapping[str, float], limit: float, filter_time: float, anti_windup: float) -> Pid:
    named = {name.rpartition(".")[2]: value for name, value in gains.items()}
    return Pid(
        named,
        sample=SAMPLE,
        filter_time=filter_time,
        limits=(-limit, limit),
        anti_windup=anti_windup,
    )


def mujoco_arm(
    gains: Mapping[str, float], reference: Recording, conditions: Conditions
) -> dict[str, Vector]:
    """PID law; its twin knows neither weight, dry friction nor the delay of two samples."""
    law = _law(gains, 40.0, 2e-3, 50.0)
    return _play(ARM, law, reference, conditions, delay=2, deviation=1e-3)


def mujoco_belt(
    gains: Mapping[str, float], reference: Recording, conditions: Conditions
) -> dict[str, Vector]:
    """PD law; its twin knows neither the belt, dry friction nor the delay of one sample."""
    law = _law(gains, 25.0, 1e-3, 0.0)
    return _play(BELT, law, reference, conditions, delay=1, deviation=2e-3)
