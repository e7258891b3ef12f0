"""Command effects on a twin with its controller inside, against the effect at its true place."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.fmu_build.effect_sizes import parameters

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

SAMPLE, FINE, END = 1e-3, 2e-5, 0.15
Actuator = Callable[[float, float], float]  # (time, command) -> what acts over the fine step


def reference(t: float) -> float:
    """A step and a sine."""
    return 0.05 * math.sin(2.0 * math.pi * 15.0 * t) + (0.1 if t >= 0.03 else 0.0)


def control(t: float, q: float, v: float) -> float:
    """Position control of a unit mass at 50 rad/s."""
    return 2500.0 * (reference(t) - q) - 80.0 * v


def true_motion(actuator: Actuator) -> NDArray[np.float64]:
    """Position at each sample with the actuator between the sampled controller and the mass."""
    q = v = u = 0.0
    rows = []
    per_sample = round(SAMPLE / FINE)
    for k in range(round(END / FINE)):
        if k % per_sample == 0:
            rows.append(q)
            u = control(k * FINE, q, v)
        a = actuator(k * FINE, u)
        q, v = q + (v + 0.5 * a * FINE) * FINE, v + a * FINE
    return np.array(rows)


def motion_through_the_port(
    new_instance: NewInstance, step: float, lateness: float, **values: float
) -> NDArray[np.float64]:
    """The same with the effect at the port of a twin that holds controller and mass."""
    effects = new_instance("physics").start(**values, settings__command_lateness=lateness)
    shown = effects.variables["state.command"].valueReference
    output = effects.variables["command"].valueReference
    q = v = u = 0.0
    rows = []
    per_sample = round(SAMPLE / step)
    for k in range(round(END / step)):
        effects.slave.setReal([shown], [u])
        effects.step(k * step, step)
        added = effects.slave.getReal([output])[0]
        if k % per_sample == 0:
            rows.append(q)
            u = control(k * step, q, v)
        a = u + added
        q, v = q + (v + 0.5 * a * step) * step, v + a * step
    return np.array(rows)


def actuators() -> dict[str, Actuator]:
    """The effects of the table below, written down a second time for a fine step."""
    line: dict[int, float] = {}
    lagged = [0.0]

    def delay(t: float, u: float) -> float:
        k = round(t / FINE)
        line[k] = u
        return line.get(k - round(1.7e-3 / FINE), 0.0)

    def lag(t: float, u: float) -> float:
        before = lagged[0]
        lagged[0] = u + (before - u) * math.exp(-FINE / 5e-3)
        return 0.5 * (before + lagged[0])

    return {
        "transport_delay": delay,
        "actuator_lag": lag,
        "actuator_saturation": lambda t, u: min(max(u, -60.0), 60.0),
        "actuator_gain_loss": lambda t, u: 0.7 * u,
    }


SIZES = {
    "transport_delay": parameters("transport_delay"),
    "actuator_lag": parameters("actuator_lag"),
    "actuator_saturation": {"actuator_saturation.limit": 60.0},
    "actuator_gain_loss": {"actuator_gain_loss.loss": 0.3},
}


@pytest.mark.parametrize("effect", SIZES)
def test_a_late_command_is_made_up_for(new_instance: NewInstance, effect: str) -> None:
    """Error as a share of what the effect does: below 0.3 % at ten steps a sample, 3 % at one."""
    truth = true_motion(actuators()[effect])
    signature = np.linalg.norm(truth - true_motion(lambda t, u: u))

    def share(step: float, lateness: float) -> float:
        result = motion_through_the_port(new_instance, step, lateness, **SIZES[effect])
        return float(np.linalg.norm(result - truth) / signature)

    assert share(SAMPLE / 10, SAMPLE / 10) < 3e-3
    assert share(SAMPLE, SAMPLE) < 0.03
    assert share(SAMPLE / 10, SAMPLE / 10) < 0.3 * share(SAMPLE / 10, 0.0)


def test_on_wires_nothing_is_made_up(new_instance: NewInstance) -> None:
    """Lateness 0: the effect's own value, for a command that jumps at every step."""
    command = np.random.default_rng(5).normal(size=50)
    effects = new_instance("physics").start(actuator_gain_loss__loss=0.3)
    added = effects.run({"state.command": command}, ["command"], SAMPLE)[1:, 0]
    np.testing.assert_allclose(added, -0.3 * command, rtol=1e-13)
