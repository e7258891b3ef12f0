"""Command effects of physics.fmu: limits, lag, delay, slope, warming; each with its closed form."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.fmu_build.effect_sizes import parameters

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

STEP = 1e-3


def acting(
    new_instance: NewInstance, command: NDArray[np.float64], step: float = STEP, **values: float
) -> NDArray[np.float64]:
    """Command that reaches the plant: the twin's and what the effects add, shape of `command`."""
    effects = new_instance("physics").start(**values)
    return command + effects.run({"state.command": command}, ["command"], step)[1:, 0]


@given(u=st.floats(-20.0, 20.0), v=st.floats(-5.0, 5.0))
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_each_limit_is_its_formula(new_instance: NewInstance, u: float, v: float) -> None:
    expected = {
        "actuator_saturation": np.clip(u, -0.5, 0.5),
        "actuator_dead_zone": np.sign(u) * max(0.0, abs(u) - 0.2),
        "actuator_gain_loss": 0.9 * u,
        "supply_voltage_limit": min(max(u, -0.8 - 0.3 * v), 0.8 - 0.3 * v),
        "magnetic_saturation": u / (1.0 + (0.4 * u) ** 2),
    }
    for effect, value in expected.items():
        result = acting(new_instance, np.array([u]), **parameters(effect), state__velocity=v)
        assert result[0] == pytest.approx(value, abs=1e-13), effect


def test_effects_on_the_command_run_in_a_chain(new_instance: NewInstance) -> None:
    """Loss, then dead zone, then limit: 3 becomes 2.7, 2.5, 0.5."""
    chain = (
        parameters("actuator_gain_loss")
        | parameters("actuator_dead_zone")
        | parameters("actuator_saturation")
    )
    result = acting(new_instance, np.array([3.0, 0.5]), **chain)
    np.testing.assert_allclose(result, [0.5, 0.25], rtol=1e-12)


@pytest.mark.parametrize("time", [1e-9, 1e-4, 5e-3, 10.0])
def test_the_lag_is_the_exact_mean_of_its_exponential(
    new_instance: NewInstance, time: float
) -> None:
    """A step to 1 after the start at 0: the integral to t is t - time (1 - exp(-t / time))."""
    command = np.concatenate([[0.0], np.ones(30)])
    t = np.arange(31, dtype=np.float64) * STEP
    integral = t + time * np.expm1(-t / time)
    result = acting(new_instance, command, actuator_lag__time=time)
    assert result[0] == 0.0
    np.testing.assert_allclose(result[1:] * STEP, np.diff(integral), rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("effect", ["actuator_lag", "actuator_rate_limit", "transport_delay"])
def test_finer_steps_have_the_same_means(new_instance: NewInstance, effect: str) -> None:
    """A command held for 1 ms gives the same impulse a millisecond, stepped 1 or 10 times."""
    command = np.cumsum(np.random.default_rng(2).normal(0.0, 0.01, 60))
    values = parameters(effect)
    coarse = acting(new_instance, command, **values)
    fine = acting(new_instance, np.repeat(command, 10), STEP / 10, **values)
    np.testing.assert_allclose(fine.reshape(-1, 10).mean(axis=1), coarse, rtol=0.0, atol=1e-12)


def test_a_lagged_command_starts_settled(new_instance: NewInstance) -> None:
    for effect in ("actuator_lag", "actuator_rate_limit", "transport_delay"):
        result = acting(new_instance, np.full(120, 2.5), **parameters(effect))
        np.testing.assert_allclose(result, 2.5, rtol=1e-12)


@given(delay=st.floats(1e-6, 0.1), slope=st.floats(-10.0, 10.0))
@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_the_delay_of_a_ramp_is_exact(
    new_instance: NewInstance, delay: float, slope: float
) -> None:
    t = np.arange(150, dtype=np.float64) * STEP
    result = acting(new_instance, slope * t, transport_delay__delay=delay)
    full = t > delay + STEP
    np.testing.assert_allclose(result[full], slope * (t[full] - delay), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("steps", [1, 3, 100])
def test_a_delay_of_whole_steps_shifts_the_samples(new_instance: NewInstance, steps: int) -> None:
    command = np.random.default_rng(3).normal(size=250)
    result = acting(new_instance, command, transport_delay__delay=steps * STEP)
    np.testing.assert_allclose(result[steps:], command[:-steps], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(result[:steps], command[0], rtol=0.0, atol=1e-11)


def test_a_delay_over_steps_of_mixed_length_keeps_the_integral(new_instance: NewInstance) -> None:
    rng = np.random.default_rng(4)
    lengths = rng.uniform(2e-4, 3e-3, 300)
    times = np.concatenate([[0.0], np.cumsum(lengths)])
    effects = new_instance("physics").start(transport_delay__delay=0.0123)
    integral = np.zeros(301)
    for k in range(300):
        effects.set(state__command=3.0 * times[k] + 1.5 * lengths[k])  # mean of 3 t
        effects.step(times[k], lengths[k])
        value = 3.0 * times[k] + 1.5 * lengths[k] + effects.get("command")
        integral[k + 1] = integral[k] + value * lengths[k]
    late = times > 0.0123 + 3e-3
    start = 1.5 * lengths[0] * 0.0123  # the first command, held before the start
    expected = start + 1.5 * (times[late] - 0.0123) ** 2
    np.testing.assert_allclose(integral[late], expected, atol=3.0 * 3e-3**2)


def test_the_longest_delay_has_room_at_half_the_internal_step(new_instance: NewInstance) -> None:
    t = np.arange(2400, dtype=np.float64) * 5e-5
    result = acting(new_instance, t, 5e-5, transport_delay__delay=0.1)
    np.testing.assert_allclose(result[2100:], t[2100:] - 0.1, rtol=0.0, atol=1e-12)


def test_a_delay_beyond_the_memory_is_refused_in_words(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(transport_delay__delay=0.1)
    with pytest.raises(RuntimeError, match="delay is longer than 2046 steps: shorten it or take"):
        effects.step(0.0, 4e-5)


def test_the_rate_limit_ramps_and_arrives(new_instance: NewInstance) -> None:
    """A step of 1 at 80 per second arrives after 12.5 ms; the means of a straight line."""
    command = np.concatenate([[0.0], np.ones(20)])
    result = acting(new_instance, command, actuator_rate_limit__rate=80.0)
    line = np.minimum(80.0 * STEP * (np.arange(20) + 0.5), 1.0)
    line[12] = 0.5 * (0.96 + 1.0) * 0.5 + 0.5  # arrives in the middle of this step
    np.testing.assert_allclose(result[1:], line, rtol=1e-12)


def test_a_slow_command_passes_the_rate_limit_but_for_half_a_step(
    new_instance: NewInstance,
) -> None:
    command = 3.0 * np.arange(50, dtype=np.float64) * STEP
    result = acting(new_instance, command, actuator_rate_limit__rate=5.0)
    assert np.abs(result - command).max() < 3.0 * STEP


@pytest.mark.parametrize("known", [0.0, 1.0])
def test_warming_follows_the_exponential_of_the_squared_current(
    new_instance: NewInstance, known: float
) -> None:
    """At a constant current of 1 and a scale of 0.5 the final loss is 4 * 0.05."""
    result = acting(
        new_instance,
        np.full(300, 1.0),
        thermal_derating__loss=0.05,
        thermal_derating__time=0.1,
        thermal_derating__scale=0.5,
        settings__current_known=known,
        state__current=1.0,
    )
    heat = -4.0 * np.expm1(-np.arange(300) * STEP / 0.1)
    np.testing.assert_allclose(result, 1.0 - 0.05 * heat, rtol=1e-12)
