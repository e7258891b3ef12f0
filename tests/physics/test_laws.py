"""Each law against its closed form, its sign, and nothing where it is off."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from gmfbo.physics import CATALOGUE, States, Values
from gmfbo.physics.timing import delayed, lagged
from tests.physics.excitations import TYPICAL, clock, swing

Array = NDArray[np.float64]
DISSIPATIVE = [
    "coulomb_friction",
    "stribeck_friction",
    "asymmetric_friction",
    "load_dependent_friction",
    "position_dependent_friction",
    "viscous_friction",
    "quadratic_drag",
]


def signal(name: str, states: States, **parameters: float) -> Array:
    law = CATALOGUE[name].signal
    assert law is not None
    return law(states, parameters)


def feature(name: str, states: States) -> Array:
    law = CATALOGUE[name].feature
    assert law is not None
    return law(states)


def along(position: Array, command: Array | None = None) -> States:
    """Make a trajectory with 1 ms steps along these positions."""
    time = clock(len(position), 1e-3)
    driven = np.zeros(len(position)) if command is None else command
    return States(time, position, np.gradient(position, time), driven, driven)


@pytest.mark.parametrize("name", DISSIPATIVE)
def test_friction_and_drag_take_power_at_every_instant(name: str) -> None:
    states = swing()
    for start in CATALOGUE[name].starts(TYPICAL):
        power = signal(name, states, **start) * states.velocity
        assert np.all(power <= 0.0)
        assert np.sum(power) < 0.0


@pytest.mark.parametrize("name", ["presliding_friction", "hysteresis"])
def test_a_loop_takes_energy_over_a_cycle_and_never_exceeds_its_level(name: str) -> None:
    phase = np.linspace(0.0, 6.0 * math.pi, 6001)
    states = along(np.sin(phase))
    for deflection in (0.01, 0.1, 1.0):
        torque = signal(name, states, level=2.0, deflection=deflection)
        middle = 0.5 * (torque[1:] + torque[:-1])
        assert float(middle[2000:] @ np.diff(states.position)[2000:]) < 0.0
        assert np.max(np.abs(torque)) <= 2.0


@pytest.mark.parametrize("name", [n for n, e in CATALOGUE.items() if e.feature is not None])
def test_a_feature_is_finite_also_at_standstill(name: str) -> None:
    still = np.zeros(50)
    assert np.all(np.isfinite(feature(name, along(still))))
    assert np.all(np.isfinite(feature(name, swing())))
    assert np.any(feature(name, swing()))


# Parameters at which each effect is off.
OFF: dict[str, Values] = {
    "coulomb_friction": {"level": 0.0},
    "stribeck_friction": {"level": 0.0, "breakaway": 0.0, "velocity": 1.0},
    "presliding_friction": {"level": 0.0, "deflection": 0.1},
    "asymmetric_friction": {"level_positive": 0.0, "level_negative": 0.0},
    "load_dependent_friction": {"level": 0.0, "coefficient": 0.0},
    "position_dependent_friction": {"level": 0.0, "sine": 0.0, "cosine": 0.0, "wavenumber": 1.0},
    "viscous_friction": {"coefficient": 0.0},
    "quadratic_drag": {"coefficient": 0.0},
    "hysteresis": {"level": 0.0, "deflection": 0.1},
    "cogging_torque": {"wavenumber_1": 7.0, "sine_1": 0.0, "cosine_1": 0.0},
    "torque_ripple": {"wavenumber_1": 7.0, "sine_1": 0.0, "cosine_1": 0.0},
    "gravity_torque": {"sine": 0.0, "cosine": 0.0},
    "elastic_return": {"stiffness": 0.0, "preload": 0.0},
    "constant_torque_offset": {"level": 0.0},
    "actuator_saturation": {"limit": 100.0},
    "actuator_dead_zone": {"width": 0.0},
    "actuator_rate_limit": {"rate": 1e6},
    "actuator_lag": {"time": 0.0},
    "actuator_gain_loss": {"loss": 0.0},
    "transport_delay": {"delay": 0.0},
    "thermal_derating": {"loss": 0.0, "time": 1.0, "scale": 1.0},
    "supply_voltage_limit": {"limit": 100.0, "slope": 0.1},
    "magnetic_saturation": {"coefficient": 0.0},
    "sensor_eccentricity": {"sine": 0.0, "cosine": 0.0},
    "sensor_lag": {"time": 0.0},
    "sensor_offset": {"level": 0.0},
    "sensor_scale": {"share": 0.0},
    "periodic_disturbance": {"frequency": 3.0, "sine": 0.0, "cosine": 0.0},
    "pulse_disturbance": {"start": 0.5, "duration": 0.1, "level": 0.0},
    "load_inertia": {"inertia": 0.0},
}


def test_each_law_is_tested_for_being_off() -> None:
    assert set(OFF) == {name for name, effect in CATALOGUE.items() if effect.signal is not None}


@pytest.mark.parametrize("name", list(OFF))
def test_an_effect_that_is_off_adds_nothing(name: str) -> None:
    assert_allclose(signal(name, swing(), **OFF[name]), 0.0, atol=1e-12)


def test_coulomb_friction_is_the_sign() -> None:
    states = swing()
    assert_allclose(feature("coulomb_friction", states), -np.sign(states.velocity))


def test_stribeck_friction_falls_from_breakaway_to_its_level() -> None:
    slow, fast = 1e-9, 1e3
    still = np.zeros(2)
    states = States(clock(2, 1.0), still, np.array([slow, fast]), still, still)
    torque = signal("stribeck_friction", states, level=1.0, breakaway=1.6, velocity=0.1)
    assert_allclose(torque, [-1.6, -1.0])


def test_a_bristle_saturates_exponentially_and_turns_steeper() -> None:
    there = np.linspace(0.0, 0.3, 301)
    states = along(np.concatenate((there, there[::-1])))
    torque = signal("presliding_friction", states, level=2.0, deflection=0.1)
    top = 1.0 - math.exp(-3.0)
    assert_allclose(torque[:301], -2.0 * (1.0 - np.exp(-there / 0.1)), atol=1e-12)
    back = (0.3 - there[::-1]) / 0.1
    assert_allclose(torque[301:], -2.0 * (-1.0 + (1.0 + top) * np.exp(-back)), atol=1e-12)


def test_hysteresis_loads_exponentially_and_returns_at_twice_the_size() -> None:
    """Masing's rule, and 1 - exp(-x) but for the number of elements."""
    there = np.linspace(0.0, 0.3, 301)
    back = np.linspace(0.3, -0.3, 601)[1:]
    states = along(np.concatenate((there, back)))
    torque = signal("hysteresis", states, level=2.0, deflection=0.1)
    assert_allclose(torque[:301], -2.0 * (1.0 - np.exp(-there / 0.1)), atol=0.03)
    assert_allclose(torque[300::2], torque[300] - 2.0 * torque[:301], atol=1e-12)


def test_a_single_step_of_hysteresis_may_unload_and_load() -> None:
    """Also behind a standstill."""
    coarse = signal("hysteresis", along(np.array([0.0, 0.3, 0.3, 0.0])), level=1.0, deflection=0.1)
    path = np.concatenate((np.linspace(0.0, 0.3, 3001), np.linspace(0.3, 0.0, 3001)))
    fine = signal("hysteresis", along(path), level=1.0, deflection=0.1)
    assert coarse[-1] == pytest.approx(fine[-1], abs=1e-9)


def test_a_spring_pulls_back_and_an_inertia_opposes_acceleration() -> None:
    states = swing()
    assert_allclose(feature("elastic_return", states), -states.position)
    assert_allclose(feature("load_inertia", states), -states.acceleration)


def test_ripple_is_cogging_in_proportion_to_the_current() -> None:
    states = swing()
    line = {"wavenumber_1": 7.0, "sine_1": 0.3, "cosine_1": -0.4}
    ripple = signal("torque_ripple", states, **line)
    assert_allclose(ripple, states.current * signal("cogging_torque", states, **line))


def test_cogging_adds_its_lines() -> None:
    states = swing()
    first = {"wavenumber_1": 7.0, "sine_1": 0.3, "cosine_1": 0.1}
    second = {"wavenumber_2": 14.0, "sine_2": 0.2, "cosine_2": -0.1}
    expected = 0.3 * np.sin(7.0 * states.position) + 0.1 * np.cos(7.0 * states.position)
    expected += 0.2 * np.sin(14.0 * states.position) - 0.1 * np.cos(14.0 * states.position)
    assert_allclose(signal("cogging_torque", states, **first, **second), expected)


def test_a_limit_clips_and_a_dead_zone_takes_its_width() -> None:
    states = along(np.zeros(5), np.array([-3.0, -0.5, 0.0, 0.5, 3.0]))
    clipped = states.command + signal("actuator_saturation", states, limit=2.0)
    assert_allclose(clipped, [-2.0, -0.5, 0.0, 0.5, 2.0])
    dead = states.command + signal("actuator_dead_zone", states, width=1.0)
    assert_allclose(dead, [-2.0, 0.0, 0.0, 0.0, 2.0])


def test_a_supply_limit_without_slope_is_a_saturation() -> None:
    states = swing()
    assert_allclose(
        signal("supply_voltage_limit", states, limit=4.0, slope=0.0),
        signal("actuator_saturation", states, limit=4.0),
    )


def test_magnetic_saturation_halves_the_command_at_its_reciprocal() -> None:
    states = along(np.zeros(2), np.array([2.0, -2.0]))
    assert_allclose(signal("magnetic_saturation", states, coefficient=0.5), [-1.0, 1.0])


def test_a_rate_limit_turns_a_step_into_a_ramp() -> None:
    states = along(np.zeros(101), np.where(np.arange(101) < 1, 0.0, 1.0))
    output = states.command + signal("actuator_rate_limit", states, rate=20.0)
    assert_allclose(output, np.minimum(1.0, 0.02 * np.arange(101)), atol=1e-12)


@pytest.mark.parametrize(("rate", "rows"), [(20.0, 49), (3000.0, 1), (1e5, 0)])
def test_a_rate_limit_acts_while_it_is_behind_also_within_a_row(rate: float, rows: int) -> None:
    """A jump by 1 at 1 kHz takes 50 ms, a third of a row, and a hundredth, which nobody sees."""
    states = along(np.zeros(101), np.where(np.arange(101) < 1, 0.0, 1.0))
    acts = CATALOGUE["actuator_rate_limit"].acts(states, {"rate": rate})
    assert np.count_nonzero(acts) == rows


def test_a_lag_falls_behind_a_ramp_by_its_time_constant() -> None:
    time = clock(5000, 1e-4)
    behind = time - lagged(time, time, 0.02)
    # Values held over each step add half a step.
    assert behind[-1] == pytest.approx(0.02 + 0.5e-4, rel=1e-3)


@pytest.mark.parametrize(("name", "parameter"), [("actuator_lag", "time"), ("sensor_lag", "time")])
def test_a_lag_starts_settled(name: str, parameter: str) -> None:
    states = along(np.ones(20), np.ones(20))
    assert_allclose(signal(name, states, **{parameter: 0.01}), 0.0, atol=1e-15)


def test_a_delay_shows_the_past() -> None:
    time = clock(2000, 1e-3)
    late = delayed(time, np.sin(5.0 * time), 0.0123)
    assert_allclose(late[100:], np.sin(5.0 * (time[100:] - 0.0123)), atol=1e-5)


@pytest.mark.parametrize(
    ("name", "parameter"),
    [("transport_delay", "delay"), ("actuator_lag", "time"), ("sensor_lag", "time")],
)
def test_lateness_is_minus_the_derivative_for_short_times(name: str, parameter: str) -> None:
    states = swing(step=1e-5)
    short = signal(name, states, **{parameter: 1e-4}) / 1e-4
    expected = feature(name, states)
    error = np.sqrt(np.mean((short - expected)[100:] ** 2) / np.mean(expected[100:] ** 2))
    assert error < 0.12  # half a step of 0.01 ms on 0.1 ms, and the curvature


def test_derating_at_constant_current_approaches_its_loss() -> None:
    states = along(np.zeros(5000), np.full(5000, 2.0))
    taken = signal("thermal_derating", states, loss=0.3, time=0.5, scale=2.0)
    expected = -0.3 * (1.0 - np.exp(-states.time / 0.5)) * 2.0
    assert_allclose(taken, expected, atol=3e-3)
    assert taken[0] == 0.0


def test_a_pulse_between_samples_keeps_its_impulse() -> None:
    states = along(np.zeros(1000))
    torque = signal("pulse_disturbance", states, start=0.30037, duration=0.05519, level=2.0)
    assert float(np.sum(torque)) * 1e-3 == pytest.approx(2.0 * 0.05519)
    acting = CATALOGUE["pulse_disturbance"].acts(
        states, {"start": 0.30037, "duration": 0.05519, "level": 2.0}
    )
    assert states.time[acting][0] == pytest.approx(0.3)
    assert states.time[acting][-1] == pytest.approx(0.355)


@pytest.mark.parametrize("name", list(CATALOGUE))
def test_an_effect_acts_somewhere_in_a_motion_that_excites_it(name: str) -> None:
    states = swing()
    for start in CATALOGUE[name].starts(TYPICAL)[-1:]:
        mask = CATALOGUE[name].acts(states, start)
        assert mask.shape == states.time.shape
        assert mask.dtype == np.bool_
        assert mask.any()


def test_saturation_acts_where_the_command_is_beyond_its_limit() -> None:
    states = swing()
    acting = CATALOGUE["actuator_saturation"].acts(states, {"limit": 5.0})
    assert np.array_equal(acting, np.abs(states.command) > 5.0)
