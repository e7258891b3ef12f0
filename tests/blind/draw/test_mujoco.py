"""The plant in MuJoCo is the twin's, and the certificate tells where it is not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.blind.draw import certificate, mujoco_axis
from tests.blind.draw.certificate import MOST, certify
from tests.blind.draw.mujoco_axis import INTEGRATORS, WHY_NOT, has_mujoco, simulate_in_mujoco
from tests.blind.machines import SERVO
from tests.blind.oracle import Experiment
from tests.blind.references import SHAPES
from tests.blind.truth import simulate

pytestmark = pytest.mark.skipif(not has_mujoco(), reason=WHY_NOT)

REFERENCE = 0.5 * SHAPES["chirp"](np.random.default_rng(4), 600)
EXPERIMENTS = [Experiment("chirp", REFERENCE, {"kp": 40.0, "kd": 0.8})]


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_certificate_holds_at_the_step_and_at_half_of_it(integrator: str) -> None:
    shown = certify(SERVO, SERVO.truth, EXPERIMENTS, integrator)
    assert shown.holds
    for differences in (shown.at_step, shown.at_half_step):
        assert set(differences) == {"position", "command"}
        assert all(share < MOST for share in differences.values())


def test_another_simulator_that_shares_no_code_agrees() -> None:
    """`truth.c` was held against the twin by itself."""
    run = simulate_in_mujoco(SERVO.truth, REFERENCE, preroll=1, step=1e-4, integrator="RK4")
    true = simulate(SERVO.truth, REFERENCE, preroll=1)
    assert np.max(np.abs(run.position - true.position)) < 1e-7
    assert np.max(np.abs(run.new - true.new)) < 1e-4


def test_euler_is_of_first_order_in_its_step() -> None:
    true = simulate(SERVO.truth, REFERENCE, preroll=1).position
    errors = [
        np.max(
            np.abs(
                simulate_in_mujoco(
                    SERVO.truth, REFERENCE, preroll=1, step=step, integrator="Euler"
                ).position
                - true
            )
        )
        for step in (5e-5, 2.5e-5)  # at coarser ones the second order shows
    ]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


def test_control_a_plant_with_another_inertia_gets_no_certificate(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def heavier(parameters: Any, *given: Any, **more: Any) -> Any:
        changed = {**parameters, "inertia": 1.01 * parameters["inertia"]}
        return simulate_in_mujoco(changed, *given, **more)

    monkeypatch.setattr(certificate, "simulate_in_mujoco", heavier)
    monkeypatch.setattr(certificate, "HALVINGS", 2)
    with pytest.raises(RuntimeError, match=r"differs from the twin .* expected less than 0\.25"):
        certify(SERVO, SERVO.truth, EXPERIMENTS, "RK4")


def test_control_a_lag_that_mujoco_integrates_at_odds_with_its_stages_gets_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of first order at best: MuJoCo's exact filter counts on undivided steps."""
    monkeypatch.setitem(mujoco_axis.INTEGRATORS, "RK4", "filterexact")
    monkeypatch.setattr(certificate, "HALVINGS", 2)
    with pytest.raises(RuntimeError, match="MuJoCo's RK4 differs from the twin"):
        certify(SERVO, SERVO.truth, EXPERIMENTS, "RK4")


def test_what_the_plant_lacks_is_refused() -> None:
    with pytest.raises(ValueError, match="the MuJoCo servo has no \\['friction_positive'\\]"):
        simulate_in_mujoco(
            {**SERVO.truth, "friction_positive": 0.1}, REFERENCE, step=1e-4, integrator="RK4"
        )


def test_steps_that_do_not_fit_a_sample_are_refused() -> None:
    with pytest.raises(ValueError, match=r"a step that divides 1 ms evenly, got 0\.0003 s"):
        simulate_in_mujoco(SERVO.truth, REFERENCE, step=3e-4, integrator="RK4")
