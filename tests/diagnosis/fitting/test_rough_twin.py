"""A twin whose own encoder dithers its command: parameters are found, and no physics with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gmfbo.diagnosis.case import open_case
from gmfbo.diagnosis.fitting.difference_steps import with_clear_steps
from gmfbo.diagnosis.fitting.hypothesis import DIFFERENCE_STEP, Hypothesis
from gmfbo.diagnosis.naming.gain_by_chance import gain_by_chance
from gmfbo.diagnosis.naming.threshold import LEAST_THRESHOLD
from tests.diagnosis.short_recordings import SERVO, Axis, diagnosed, multisine, open_small, triangle

DRIVE = Axis(
    "drive_twin",
    "reference",
    {"load.inertia": 0.17, "friction.viscous": 0.25},
    {"ctl.Kp": 120.0, "ctl.Kd": 5.0},
    {"torque_command": 0.05},
)


def test_parameters_are_found_through_the_counts_of_the_twins_encoder() -> None:
    case = open_small(DRIVE.twin(), DRIVE.recordings({}, (multisine, triangle)))
    try:
        assert case.setting.is_rough
        assert case.base.parameters["load.inertia"] == pytest.approx(0.17, rel=5e-3)
        assert case.base.parameters["friction.viscous"] == pytest.approx(0.25, rel=0.05)
    finally:
        case.simulations.close()


def test_negative_control_steps_of_the_usual_size_end_far_from_the_parameters(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        open_case, "with_clear_steps", lambda misfit, hypothesis, *_, **__: hypothesis
    )
    case = open_small(DRIVE.twin(), DRIVE.recordings({}, (multisine, triangle)))
    try:
        assert not case.setting.is_rough
        assert abs(case.base.parameters["friction.viscous"] - 0.25) > 0.02
    finally:
        case.simulations.close()


def test_other_parameters_of_a_rough_twin_are_not_missing_physics() -> None:
    friction = ("coulomb_friction", "presliding_friction", "viscous_friction", "sensor_lag")
    diagnosis = diagnosed(DRIVE.twin(), DRIVE.recordings({}, (multisine, triangle)), only=friction)
    assert diagnosis.verdict == "parameters"
    assert not diagnosis.effects


def test_chi2_varies_where_only_counts_change_and_not_in_a_smooth_twin() -> None:
    found = []
    for axis in (DRIVE, SERVO):
        case = open_small(axis.twin(), axis.recordings({}, (multisine, triangle)))
        try:
            found.append(gain_by_chance(case.misfit, case.base, np.random.default_rng(0)))
        finally:
            case.simulations.close()
    assert found[0] > LEAST_THRESHOLD
    assert found[1] == 0.0


def test_a_smooth_twin_is_moved_by_the_usual_steps() -> None:
    case = open_small(SERVO.twin(), SERVO.recordings({}))
    try:
        assert set(case.setting.difference_steps.values()) == {DIFFERENCE_STEP}
        assert not case.setting.is_rough
    finally:
        case.simulations.close()


def test_steps_that_are_known_stay_and_ask_for_no_run() -> None:
    case = open_small(SERVO.twin(), SERVO.recordings({}))
    try:
        known = dict.fromkeys(Hypothesis(case.setting).names, 0.02)
        hypothesis = Hypothesis(replace(case.setting, difference_steps=known))
        before = case.simulations.runs
        again = with_clear_steps(case.misfit, hypothesis, {}, parallel=False)
        assert again.setting.difference_steps == known
        assert case.simulations.runs == before
    finally:
        case.simulations.close()
