"""Torques of physics.fmu with a closed form: of velocity, position, current and time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from tests.fmu_build.effect_sizes import parameters
from tests.fmu_build.shaft import run_shaft

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

ANY = st.floats(-5.0, 5.0)


@given(q=ANY, v=ANY, i=ANY)
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_each_torque_is_its_formula(
    new_instance: NewInstance, q: float, v: float, i: float
) -> None:
    expected = {
        "viscous_friction": -0.1 * v,
        "quadratic_drag": -0.1 * v * abs(v),
        "cogging_torque": 0.1 * np.sin(7.0 * q) + 0.1 * np.cos(28.0 * q),
        "torque_ripple": i * (0.1 * np.sin(7.0 * q) + 0.1 * np.cos(14.0 * q)),
        "gravity_torque": 0.2 * np.sin(q) + 0.3 * np.cos(q),
        "elastic_return": 0.1 - 0.5 * q,
        "constant_torque_offset": 0.2,
    }
    for effect, torque in expected.items():
        effects = new_instance("physics").start(**parameters(effect))
        effects.set(state__position=q, state__velocity=v, state__command=i)
        effects.step(0.0, 1e-3)
        assert effects.get("torque") == pytest.approx(torque, rel=1e-12, abs=1e-14), effect


def test_all_harmonics_of_the_cogging_torque_add_up(new_instance: NewInstance) -> None:
    rng = np.random.default_rng(1)
    wavenumber, sine, cosine = rng.normal(size=(3, 4)) * [[20.0], [1.0], [1.0]]
    values = {
        f"cogging_torque.{name}_{k + 1}": float(row[k])
        for name, row in (("wavenumber", wavenumber), ("sine", sine), ("cosine", cosine))
        for k in range(4)
    }
    effects = new_instance("physics").start(**values, state__position=0.7)
    effects.step(0.0, 1e-3)
    expected = sine @ np.sin(wavenumber * 0.7) + cosine @ np.cos(wavenumber * 0.7)
    assert effects.get("torque") == pytest.approx(expected, rel=1e-12)


def test_the_ripple_follows_the_current_where_it_is_known(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(
        torque_ripple__cosine_1=0.1,
        settings__current_known=1.0,
        state__current=-3.0,
        state__command=8.0,
    )
    effects.step(0.0, 1e-3)
    assert effects.get("torque") == pytest.approx(-0.3)


@pytest.mark.parametrize("step", [1e-4, 1e-3, 7e-3])
def test_a_periodic_disturbance_is_its_mean_over_each_step(
    new_instance: NewInstance, step: float
) -> None:
    effects = new_instance("physics").start(**parameters("periodic_disturbance"))
    table = effects.run({}, ["torque"], step, rows=20)[1:, 0]
    rate = 2.0 * np.pi * 30.0
    expected = [
        quad(lambda t: 0.1 * np.sin(rate * t) + 0.2 * np.cos(rate * t), k * step, (k + 1) * step)[0]
        for k in range(20)
    ]
    np.testing.assert_allclose(table * step, expected, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("step", [1e-4, 7e-4, 1e-3])
@given(start=st.floats(-0.01, 0.05), duration=st.floats(0.0, 0.03))
@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_pulse_has_its_exact_impulse_whatever_the_step(
    new_instance: NewInstance, step: float, start: float, duration: float
) -> None:
    effects = new_instance("physics").start(
        pulse_disturbance__start=start,
        pulse_disturbance__duration=duration,
        pulse_disturbance__level=0.3,
    )
    rows = round(0.1 / step)
    impulse = effects.run({}, ["torque"], step, rows=rows)[1:, 0].sum() * step
    expected = 0.3 * max(0.0, start + duration - max(start, 0.0))
    assert impulse == pytest.approx(expected, abs=1e-13)


def test_viscous_friction_decays_a_velocity_to_first_order(new_instance: NewInstance) -> None:
    """v = v0 exp(-c t / J)."""
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4):
        effects = new_instance("physics").start(viscous_friction__coefficient=0.02)
        run = run_shaft(effects, 1e-3, step, 0.1, start=(0.0, 3.0))
        errors.append(abs(run.v[-1] - 3.0 * np.exp(-2.0)))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(np.abs(orders - 1.0) < 0.1), orders


def test_an_elastic_return_swings_at_its_natural_frequency(new_instance: NewInstance) -> None:
    """Shaft of 1e-3 on 0.4: 20 rad/s about preload / stiffness."""
    effects = new_instance("physics").start(
        elastic_return__stiffness=0.4, elastic_return__preload=0.04
    )
    run = run_shaft(effects, 1e-3, 1e-4, 0.5, start=(0.3, 0.0))
    np.testing.assert_allclose(run.q, 0.1 + 0.2 * np.cos(20.0 * run.t), atol=3e-3)
