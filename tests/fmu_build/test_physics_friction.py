"""Dry friction in physics.fmu: levels while sliding, rest without ringing, exact stopping."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from tests.fmu_build.fmu_instance import FmuInstance
from tests.fmu_build.shaft import ShaftRun, run_shaft

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

INERTIA, LEVEL = 1e-3, 0.1
LAWS: dict[str, dict[str, float]] = {
    "coulomb_friction": {"level": LEVEL},
    "stribeck_friction": {"level": 0.5 * LEVEL, "breakaway": LEVEL, "velocity": 0.5},
    "presliding_friction": {"level": LEVEL},
    "asymmetric_friction": {"level_positive": LEVEL, "level_negative": 0.7 * LEVEL},
    "load_dependent_friction": {"level": LEVEL, "coefficient": 0.5},
    "position_dependent_friction": {"level": LEVEL, "sine": 0.4 * LEVEL, "wavenumber": 5.0},
}


def friction(new_instance: NewInstance, law: str, deflection: float) -> FmuInstance:
    """The law at its size above."""
    values = {f"{law}.{name}": value for name, value in LAWS[law].items()}
    return new_instance("physics").start(**values, **{f"{law}.deflection": deflection})


def stiffest(step: float, level: float = LEVEL) -> float:
    """Deflection at which level / deflection * step^2 / inertia is 0.1."""
    return level * step**2 / (0.1 * INERTIA)


def sliding_torque(new_instance: NewInstance, law: str, velocity: float, **inputs: float) -> float:
    """Torque once the bristle has yielded."""
    effects = friction(new_instance, law, 1e-6)
    effects.set(state__velocity=velocity, **inputs)
    for k in range(3):
        effects.step(k * 1e-3, 1e-3)
    return effects.get("torque")


@pytest.mark.parametrize("velocity", [-3.0, -0.4, 0.4, 3.0])
def test_the_sliding_torque_is_exactly_minus_the_level(
    new_instance: NewInstance, velocity: float
) -> None:
    sign = np.sign(velocity)
    stribeck = 0.05 + 0.05 * np.exp(-((velocity / 0.5) ** 2))
    expected = {
        "coulomb_friction": LEVEL,
        "stribeck_friction": stribeck,
        "presliding_friction": LEVEL,
        "asymmetric_friction": LEVEL if velocity > 0.0 else 0.7 * LEVEL,
        "load_dependent_friction": LEVEL,
        "position_dependent_friction": LEVEL,
    }
    for law, level in expected.items():
        torque = sliding_torque(new_instance, law, velocity)
        assert torque == pytest.approx(-sign * level, rel=1e-14), law


def test_the_level_follows_the_magnitude_of_the_load(new_instance: NewInstance) -> None:
    law = "load_dependent_friction"
    for load in (-2.0, 2.0):
        by_command = sliding_torque(new_instance, law, 1.0, state__command=load)
        by_current = sliding_torque(
            new_instance, law, 1.0, state__current=load, settings__current_known=1.0
        )
        by_load = sliding_torque(
            new_instance, law, 1.0, state__load_torque=load, settings__load_torque_known=1.0
        )
        assert by_command == by_current == by_load == pytest.approx(-(LEVEL + 0.5 * 2.0))


def test_under_a_shake_both_levels_of_asymmetric_friction_act_in_turn(
    new_instance: NewInstance,
) -> None:
    """Friction that jumps with the velocity has half the difference of both levels as its mean.

    To and fro by a hundredth of the deflection, after sliding forth: the bristle never yields.
    """
    effects = friction(new_instance, "asymmetric_friction", 1e-3)
    torques = []
    for k in range(4000):
        effects.set(state__velocity=0.05 if k < 200 else 0.01 * (-1.0) ** k)
        effects.step(k * 1e-3, 1e-3)
        torques.append(effects.get("torque"))
    assert torques[199] == pytest.approx(-LEVEL, rel=1e-3)
    assert np.mean(torques[-1000:]) == pytest.approx(-0.5 * (LEVEL - 0.7 * LEVEL), rel=0.02)


def test_asymmetric_friction_begins_without_a_torque(new_instance: NewInstance) -> None:
    effects = friction(new_instance, "asymmetric_friction", 1e-3)
    effects.step(0.0, 1e-3)
    assert effects.get("torque") == 0.0


@given(position=st.floats(-10.0, 10.0), sine=st.floats(-0.5, 0.5), cosine=st.floats(-0.5, 0.5))
@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_level_that_varies_with_position_never_drives(
    new_instance: NewInstance, position: float, sine: float, cosine: float
) -> None:
    effect = "position_dependent_friction"
    shape = {"level": LEVEL, "sine": sine, "cosine": cosine, "wavenumber": 5.0}
    effects = new_instance("physics").start(**{f"{effect}.{k}": v for k, v in shape.items()})
    effects.set(state__position=position, state__velocity=1.0)
    effects.step(0.0, 1e-3)
    wave = LEVEL + sine * np.sin(5.0 * position) + cosine * np.cos(5.0 * position)
    assert effects.get("torque") == pytest.approx(-max(0.0, wave), rel=1e-13, abs=1e-16)


def test_presliding_is_the_exact_exponential_of_the_travel(new_instance: NewInstance) -> None:
    """Dahl at constant velocity: F = -level (1 - exp(-x / deflection)), at the ends of steps."""
    effects = friction(new_instance, "presliding_friction", 0.02)
    table = effects.run({"state.velocity": np.full(200, 0.5)}, ["torque"], 1e-3)[1:, 0]
    travel = 0.5 * 1e-3 * np.arange(1, 201)
    end = 1.0 - np.exp(-travel / 0.02)
    lead = end + np.diff(end, prepend=0.0)  # one step of the bend's own change
    np.testing.assert_allclose(table, -LEVEL * np.minimum(lead, 1.0), rtol=1e-12)


@pytest.mark.parametrize("step", [1e-3, 1e-4])
@pytest.mark.parametrize("law", LAWS)
def test_a_load_below_the_level_is_held_without_ringing(
    new_instance: NewInstance, law: str, step: float
) -> None:
    """The stiffest bristle that the step allows: at rest within 40 steps, for good."""
    run = run_shaft(
        friction(new_instance, law, stiffest(step)),
        INERTIA,
        step,
        200 * step,
        drive=lambda t, q, v: 0.5 * LEVEL,
    )
    speed_of_a_step = LEVEL * step / INERTIA
    settled = 120 if law == "presliding_friction" else 40
    assert np.abs(run.v[settled:]).max() < 0.02 * speed_of_a_step
    assert run.q.max() < 1.6 * stiffest(step)
    np.testing.assert_allclose(run.torque[-5:], -0.5 * LEVEL, rtol=1e-2)


@pytest.mark.parametrize("step", [1e-3, 1e-4])
@pytest.mark.parametrize("law", ["coulomb_friction", "presliding_friction", "asymmetric_friction"])
def test_a_load_above_the_level_accelerates_by_the_difference(
    new_instance: NewInstance, law: str, step: float
) -> None:
    run = run_shaft(
        friction(new_instance, law, stiffest(step)),
        INERTIA,
        step,
        300 * step,
        drive=lambda t, q, v: 1.5 * LEVEL,
    )
    acceleration = np.diff(run.v[-100:]) / step
    np.testing.assert_allclose(acceleration, 0.5 * LEVEL / INERTIA, rtol=1e-9)


def stopping(new_instance: NewInstance, step: float) -> ShaftRun:
    """A mass at 5 rad/s that Coulomb friction alone brings to rest."""
    effects = friction(new_instance, "coulomb_friction", stiffest(step))
    return run_shaft(effects, INERTIA, step, 0.1, start=(0.0, 5.07))


def test_a_sliding_mass_stops_where_coulomb_friction_stops_it(new_instance: NewInstance) -> None:
    """q = J v^2 / (2 level); the rest error falls with the square of the step."""
    exact = INERTIA * 5.07**2 / (2.0 * LEVEL)
    steps = (1e-3, 5e-4, 2.5e-4, 1.25e-4)
    errors = [abs(stopping(new_instance, step).q[-1] - exact) for step in steps]
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(orders > 1.5), orders
    assert errors[-1] < 1e-4 * exact


def test_a_sliding_mass_stops_when_coulomb_friction_stops_it(new_instance: NewInstance) -> None:
    exact = INERTIA * 5.07 / LEVEL
    for step in (1e-3, 1e-4):
        run = stopping(new_instance, step)
        k = int(np.argmax(run.v <= 0.0))
        time = run.t[k - 1] + step * run.v[k - 1] / (run.v[k - 1] - run.v[k])
        assert time == pytest.approx(exact, abs=0.2 * step)
        assert np.abs(run.v[run.t > exact + 40 * step]).max() < 0.02 * LEVEL * step / INERTIA


def test_friction_under_a_swing_takes_level_times_path(new_instance: NewInstance) -> None:
    """Each half swing of a mass on a spring is 2 level / stiffness shorter (Lorenz 1924)."""
    step = 1e-4
    effects = new_instance("physics").start(
        coulomb_friction__level=0.02, coulomb_friction__deflection=stiffest(step, 0.02)
    )
    run = run_shaft(
        effects,
        INERTIA,
        step,
        0.4,
        start=(0.2, 0.0),
        drive=lambda t, q, v: -5.0 * (q + 0.5 * v * step),
    )
    turning = np.flatnonzero(run.v[1:-1] * run.v[2:] < 0.0) + 1
    amplitudes = np.abs(run.q[turning])[:8]
    expected = 0.2 - 0.008 * np.arange(1, 9)
    np.testing.assert_allclose(amplitudes, expected, atol=2e-4)


def test_a_reversal_within_a_step_is_no_kick(new_instance: NewInstance) -> None:
    rng = np.random.default_rng(0)
    velocity = rng.normal(0.0, 1.0, 500)
    for law in LAWS:
        torque = friction(new_instance, law, 1e-4).run(
            {"state.velocity": velocity}, ["torque"], 1e-3
        )
        assert np.abs(torque).max() <= 1.0000001 * LEVEL, law


@given(
    velocity=arrays(np.float64, 60, elements=st.floats(-2.0, 2.0)),
    deflection=st.sampled_from([1e-6, 1e-4, 1e-2]),
)
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_friction_gives_back_no_more_than_its_bristle_holds(
    new_instance: NewInstance, velocity: NDArray[np.float64], deflection: float
) -> None:
    """A bristle bent to the level returns (1 - ln 2) level deflection on the way to zero."""
    torque = friction(new_instance, "coulomb_friction", deflection).run(
        {"state.velocity": velocity}, ["torque"], 1e-3
    )[1:, 0]
    given_back = np.cumsum(torque * velocity * 1e-3)
    assert given_back.max() <= (1.0 - np.log(2.0)) * LEVEL * deflection + 1e-15


def test_a_bristle_rests_on_a_differentiated_position_too(new_instance: NewInstance) -> None:
    step = 1e-3
    effects = friction(new_instance, "coulomb_friction", stiffest(step))
    effects.set(settings__velocity_from_position=1.0)
    run = run_shaft(effects, INERTIA, step, 0.2, drive=lambda t, q, v: 0.5 * LEVEL)
    assert np.abs(run.v[40:]).max() < 1e-3 * LEVEL * step / INERTIA


def test_laws_that_act_together_rest_together(new_instance: NewInstance) -> None:
    """Three bristles, each the stiffest that the step allows."""
    step = 1e-3
    laws = ("coulomb_friction", "asymmetric_friction", "stribeck_friction")
    values = {f"{law}.{name}": value for law in laws for name, value in LAWS[law].items()}
    effects = new_instance("physics").start(
        **values, **{f"{law}.deflection": stiffest(step) for law in laws}
    )
    run = run_shaft(effects, INERTIA, step, 0.3, drive=lambda t, q, v: 2.0 * LEVEL)
    assert np.abs(run.v[60:]).max() < 0.02 * LEVEL * step / INERTIA
    assert run.torque[-1] == pytest.approx(-2.0 * LEVEL, rel=1e-3)
