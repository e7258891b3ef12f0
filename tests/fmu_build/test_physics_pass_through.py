"""physics.fmu as a whole: nothing where all is off, each effect at its own port, states."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.fmu_build.effect_sizes import SHOWING, parameters, port_of, shape

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

STEP = 1e-3
PORTS = ["torque", "command", "sensor"]
EVERYTHING = {name: value for effect in SHOWING for name, value in parameters(effect).items()}


def motion(rows: int = 40) -> dict[str, NDArray[np.float64]]:
    """A swing to and fro with a command, and something on each port."""
    t = np.arange(rows) * STEP
    angle = 2.0 * np.pi * 25.0 * t
    return {
        "state.position": 0.3 + 0.02 * np.sin(angle),
        "state.velocity": np.pi * np.cos(angle),
        "state.command": 1.5 * np.sin(angle + 1.0),
        "state.current": np.cos(angle),
        "state.load_torque": np.sin(2.0 * angle),
        "port.torque": np.where(t > 0.01, -0.0, 0.1 + t / 3.0),
        "port.command": np.where(t > 0.01, -0.0, np.exp(t)),
        "port.sensor": np.where(t > 0.01, 5e-324, -1.0 - t),
        "tracking.measured": 0.3 + 0.02 * np.sin(angle + 0.1),
    }


def test_every_effect_of_the_declaration_has_a_size_that_shows(new_instance: NewInstance) -> None:
    declared = {
        name.split(".")[0]
        for name, variable in new_instance("physics").variables.items()
        if variable.causality == "parameter"
    }
    assert declared - {"settings", "tracking"} == set(SHOWING)


def test_without_effects_every_bit_passes(new_instance: NewInstance) -> None:
    """Signs of zero and denormal numbers too."""
    inputs = motion()
    table = new_instance("physics").start().run(inputs, PORTS, STEP)
    passed = np.column_stack([inputs[f"port.{port}"] for port in PORTS])
    assert table[1:].tobytes() == passed.tobytes()


@pytest.mark.parametrize("effect", SHOWING)
def test_an_effect_at_size_zero_is_off_whatever_its_shape(
    new_instance: NewInstance, effect: str
) -> None:
    inputs = motion()
    table = new_instance("physics").start(**shape(effect)).run(inputs, PORTS, STEP)
    passed = np.column_stack([inputs[f"port.{port}"] for port in PORTS])
    assert table[1:].tobytes() == passed.tobytes()


@pytest.mark.parametrize("effect", SHOWING)
def test_an_effect_acts_on_its_own_port_only(new_instance: NewInstance, effect: str) -> None:
    inputs = motion()
    table = new_instance("physics").start(**parameters(effect)).run(inputs, PORTS, STEP)
    passed = np.column_stack([inputs[f"port.{port}"] for port in PORTS])
    acting = np.abs(table[1:] - passed).max(axis=0) > 1e-4
    assert [port for port, acts in zip(PORTS, acting, strict=True) if acts] == [port_of(effect)]


def test_effects_on_the_torque_add_up(new_instance: NewInstance) -> None:
    inputs = {name: column for name, column in motion().items() if not name.startswith("port.")}
    torques = [effect for effect in SHOWING if port_of(effect) == "torque"]
    alone = [
        new_instance("physics").start(**parameters(effect)).run(inputs, ["torque"], STEP)
        for effect in torques
    ]
    together = new_instance("physics").start(**EVERYTHING).run(inputs, ["torque"], STEP)
    np.testing.assert_allclose(together, np.sum(alone, axis=0), rtol=0.0, atol=1e-12)


def test_outputs_start_as_what_the_ports_give(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(
        port__torque=0.1, port__command=-0.2, port__sensor=0.3, **EVERYTHING
    )
    assert [effects.get(port) for port in PORTS] == [0.1, -0.2, 0.3]


def test_a_restored_state_continues_identically_with_everything_on(
    new_instance: NewInstance,
) -> None:
    tracking = {"tracking.kp": 3.0, "tracking.kd": 0.01, "settings.command_lateness": STEP}
    effects = new_instance("physics").start(**EVERYTHING, **tracking)
    inputs = motion()
    effects.run(inputs, PORTS, STEP, rows=15)
    state = effects.slave.getFMUstate()
    stored = effects.slave.serializeFMUstate(state)
    expected = effects.run(inputs, PORTS, STEP, first=15, rows=25)
    effects.slave.setFMUstate(state)
    effects.slave.freeFMUstate(state)
    np.testing.assert_array_equal(effects.run(inputs, PORTS, STEP, first=15, rows=25), expected)

    other = new_instance("physics").start()
    restored = other.slave.deSerializeFMUstate(stored)
    other.slave.setFMUstate(restored)
    other.slave.freeFMUstate(restored)
    np.testing.assert_array_equal(other.run(inputs, PORTS, STEP, first=15, rows=25), expected)


def test_reset_leaves_no_trace_of_a_run_with_everything_on(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(**EVERYTHING)
    effects.run(motion(), PORTS, STEP)
    effects.slave.reset()
    fresh = new_instance("physics").start(**EVERYTHING).run(motion(), PORTS, STEP)
    np.testing.assert_array_equal(effects.start(**EVERYTHING).run(motion(), PORTS, STEP), fresh)


def test_an_effect_that_comes_back_has_forgotten(new_instance: NewInstance) -> None:
    """Switched off and on again, memory starts anew: no load runs on behind the scenes."""
    effects = new_instance("physics").start(**EVERYTHING)
    effects.run(motion(), PORTS, STEP)
    for name, value in EVERYTHING.items():
        size_zero = name.split(".")[1] not in ("exponent",)
        effects.set(**{name: 0.0 if size_zero else value})
    effects.set(state__position=0.3, state__velocity=0.0, state__command=0.7)
    effects.run({}, PORTS, STEP, first=40, rows=5)
    effects.set(**parameters("backlash"), **parameters("actuator_lag"), **parameters("sensor_lag"))
    table = effects.run({}, PORTS, STEP, first=45, rows=5)
    passed = [effects.get(f"port.{port}") for port in PORTS]
    np.testing.assert_array_equal(table[1:], np.tile(passed, (5, 1)))
