"""A twin whose own encoder dithers its command: parameters are found, and no physics with them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest

from gmfbo import diagnose
from gmfbo.diagnosis.case import open_case
from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.difference_steps import with_clear_steps
from gmfbo.diagnosis.fitting.hypothesis import DIFFERENCE_STEP, Hypothesis
from tests.diagnosis.short_recordings import (
    SERVO,
    Axis,
    diagnosed,
    moves,
    multisine,
    open_small,
    triangle,
)

DRIVE = Axis(
    "drive_twin",
    "reference",
    {"load.inertia": 0.17, "friction.viscous": 0.25},
    {"ctl.Kp": 120.0, "ctl.Kd": 5.0},
    {"torque_command": 0.05},
)


@pytest.fixture(scope="module")
def rough() -> Iterator[Case]:
    case = open_small(DRIVE.twin(), DRIVE.recordings({}, (multisine, triangle)))
    yield case
    case.simulations.close()


@pytest.fixture(scope="module")
def smooth() -> Iterator[Case]:
    case = open_small(SERVO.twin(), SERVO.recordings({}))
    yield case
    case.simulations.close()


def test_parameters_are_found_through_the_counts_of_the_twins_encoder(rough: Case) -> None:
    assert rough.setting.is_rough
    assert rough.base.parameters["load.inertia"] == pytest.approx(0.17, rel=5e-3)
    assert rough.base.parameters["friction.viscous"] == pytest.approx(0.25, rel=0.05)


@pytest.mark.slow
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
    assert any("enc.resolution, enc.motor_resolution" in note for note in diagnosis.notes)


def test_a_smooth_twin_is_moved_by_the_usual_steps(smooth: Case) -> None:
    assert set(smooth.setting.difference_steps.values()) == {DIFFERENCE_STEP}
    assert not smooth.setting.is_rough


def test_steps_that_are_known_stay_and_ask_for_no_run(smooth: Case) -> None:
    known = dict.fromkeys(Hypothesis(smooth.setting).names, 0.02)
    hypothesis = Hypothesis(replace(smooth.setting, difference_steps=known))
    before = smooth.simulations.runs
    again = with_clear_steps(smooth.misfit, hypothesis, {}, parallel=False)
    assert again.setting.difference_steps == known
    assert smooth.simulations.runs == before


@pytest.mark.slow
def test_nothing_is_told_where_only_counts_fall_otherwise() -> None:
    """Squares of the refitted twin are less by 33 of 10,000, by chance, and were "parameters"."""
    axis = replace(DRIVE, truth={})
    with axis.twin() as twin:
        found = diagnose(twin, axis.recordings({}, (multisine, moves, triangle)), seed=0)
    assert found.verdict == "none"
