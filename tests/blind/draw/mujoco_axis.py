"""The servo axis with its plant in MuJoCo, under the controller of `servo_axis.c`."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from typing import Any

import numpy as np

from tests.blind.truth import PREROLL, SAMPLE, TrueRun, Vector

WHY_NOT = 'the package mujoco is missing: pip install "gmfbo[tests]"'

INTEGRATORS = {"Euler": "filterexact", "implicitfast": "filterexact", "RK4": "filter"}
"""Of MuJoCo, each with the lag of the motor that it integrates consistently: the exact filter
counts on steps that are not divided into stages."""

_MODEL = """<mujoco>
  <option timestep="{step!r}" integrator="{integrator}" gravity="0 0 0"/>
  <worldbody>
    <body>
      <joint name="shaft" type="hinge" axis="0 0 1" damping="{viscous!r}"/>
      <inertial pos="0 0 0" mass="1" diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>
    </body>
  </worldbody>
  <actuator>
    <general joint="shaft" dyntype="{lag}" dynprm="{torque_lag!r}" gainprm="{torque_gain!r}"/>
  </actuator>
</mujoco>"""


def has_mujoco() -> bool:
    """Whether MuJoCo is installed."""
    return importlib.util.find_spec("mujoco") is not None


def simulate_in_mujoco(
    parameters: Mapping[str, float],
    reference: Vector,
    noise: Vector | None = None,
    preroll: int = PREROLL,
    *,
    step: float,
    integrator: str,
) -> TrueRun:
    """One recording's worth of a servo whose plant MuJoCo integrates.

    Parameters
    ----------
    parameters : mapping of str to float
        By the names of `truth.c`: plant, gains, `filter_time`, `u_limit`, `quantum`. The torque
        is one motor's on a hinge with damping, behind a first-order lag.
    reference : ndarray, shape (rows,)
        [rad] Held from one sample to the next.
    noise : ndarray, shape (preroll + rows,), optional
        [rad] Added to the readings.
    preroll : int
        Samples under the first reference, not recorded.
    step : float
        [s] MuJoCo's; a whole number of them makes a sample of 1 ms.
    integrator : str
        One of `INTEGRATORS`.

    Returns
    -------
    TrueRun
        As `truth.simulate` gives it; nothing is ever limited, so `active` is zero.

    Raises
    ------
    RuntimeError
        MuJoCo is not installed.
    ValueError
        The steps do not fit a sample, or a parameter is one that this plant lacks.
    """
    if not has_mujoco():
        raise RuntimeError(WHY_NOT)
    lacking = {k for k, v in parameters.items() if v and k not in _KNOWN}
    if lacking:
        raise ValueError(f"the MuJoCo servo has no {sorted(lacking)}")
    substeps = round(SAMPLE / step)
    if abs(substeps * step - SAMPLE) > 1e-12:
        raise ValueError(f"expected a step that divides 1 ms evenly, got {step:g} s")
    plant = _Plant(parameters, step, integrator, substeps)
    controller = _Controller(parameters)
    rows = len(reference)
    added = np.zeros(preroll + rows) if noise is None else noise
    out = np.zeros((6, rows))
    command, quantum = 0.0, float(parameters.get("quantum", 0.0))
    for k in range(-preroll, rows):
        position, velocity = plant.state()
        reading = position + float(added[preroll + k])
        if quantum:
            reading = quantum * float(np.floor(reading / quantum + 0.5))
        held, command = command, controller.command(float(reference[max(k, 0)]), reading)
        if k >= 0:
            out[:5, k] = reading, held, command, position, velocity
        plant.advance(command)
    return TrueRun(*out)


_KNOWN = frozenset(
    {
        *("kind", "inertia", "viscous", "torque_gain", "torque_lag", "kp", "kd", "filter_time"),
        *("u_limit", "quantum", "ki"),
    }
)


class _Controller:
    """The law of `servo_axis.c`: u_k = sat(kp (r_k - y_k) - kd d_k), d the filtered difference."""

    def __init__(self, parameters: Mapping[str, float]) -> None:
        self._p = parameters
        self._previous: float | None = None
        self._rate = 0.0

    def command(self, reference: float, measured: float) -> float:
        """Command of the next sample [N m]."""
        p = self._p
        difference = 0.0 if self._previous is None else measured - self._previous
        filter_time = p["filter_time"]
        self._rate = (filter_time * self._rate + difference) / (filter_time + SAMPLE)
        self._previous = measured
        wanted = p["kp"] * (reference - measured) - p["kd"] * self._rate
        return min(max(wanted, -p["u_limit"]), p["u_limit"])


class _Plant:
    """One hinge and one motor in MuJoCo."""

    def __init__(
        self, parameters: Mapping[str, float], step: float, integrator: str, substeps: int
    ) -> None:
        import mujoco

        values = {name: float(value) for name, value in parameters.items()}
        lag = INTEGRATORS[integrator]
        text = _MODEL.format(**values, step=step, integrator=integrator, lag=lag)
        self._advance: Any = mujoco.mj_step
        self._model: Any = mujoco.MjModel.from_xml_string(text)
        self._data: Any = mujoco.MjData(self._model)
        self._substeps = substeps

    def state(self) -> tuple[float, float]:
        """Position [rad] and velocity [rad/s]."""
        return float(self._data.qpos[0]), float(self._data.qvel[0])

    def advance(self, command: float) -> None:
        """One sample under a held command [N m]."""
        self._data.ctrl[0] = command
        self._advance(self._model, self._data, self._substeps)
