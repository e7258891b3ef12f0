"""A twin that reads its position in counts is compared without them."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo import FmuTwin, models_folder
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of, problem_on
from gmfbo.diagnosis.comparison.starting.encoder_counts import encoder_counts
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.runs.quantum import resolution
from gmfbo.sources.twin_file.entries import FixedNames
from tests.diagnosis.short_recordings import SERVO, Axis, moves, multisine, open_small

DRIVE = Axis(
    "drive_twin",
    "reference",
    {"load.inertia": 0.17, "friction.viscous": 0.25},
    {"ctl.Kp": 120.0, "ctl.Kd": 5.0},
    {"torque_command": 0.05},
)
COUNT = 2.0 * np.pi / 4096.0  # [rad]


def test_the_parameters_that_set_counts_are_found_and_simulations_have_none() -> None:
    case = open_small(DRIVE.twin(), DRIVE.recordings({}, (multisine, moves)))
    with case.simulations:
        found = encoder_counts(case)
        assert found is not None
        # The motor's encoder is no output of the twin, but its counts shuffle the command.
        assert found.values == {"enc.resolution": 4096e3, "enc.motor_resolution": 4096e3}
        assert found.count == pytest.approx(COUNT, rel=1e-6)
        problem = problem_on(case, case.budget.windows, found)
        hypothesis = Hypothesis(case.setting)
        run = case.simulations.run([problem.point(hypothesis, case.base.x)])[0][0]
        position, counted = (r.response.held["position"] for r in (run, case.base.simulated[0]))
        assert resolution(counted) == pytest.approx(COUNT, rel=1e-6)
        assert resolution(position) < 0.01 * COUNT
        assert case.setting.is_rough
        stated = comparison_of(case, [])
        ledger = stated.search.opened(stated.first)
    # Without counts usual difference steps show a smooth answer.
    assert not stated.first.hypothesis.setting.is_rough
    sensed = ledger.kernels.kernels["sensor"]
    assert np.abs(sensed["position"] - np.eye(1, sensed["position"].size)[0]).max() < 0.1
    # What is not simulated is played, and the reading has no less noise.
    assert ledger.kernels.beyond_rounding(3e-3) == pytest.approx(3e-3)
    assert ledger.levels.ports["sensor"] > 0.99 * COUNT / np.sqrt(12.0)
    elements = {one.name for one in stated.search.elements}
    assert not elements & {"parameter:enc.resolution", "parameter:enc.motor_resolution"}


def test_a_parameter_that_nobody_may_doubt_sets_the_counts_as_well() -> None:
    twin = FmuTwin(models_folder() / "drive_twin.toml")
    file = twin.file.model_copy(update={"fixed": FixedNames(names=["enc.*"])})
    case = open_small(twin.with_file(file), DRIVE.recordings({}, (moves,)))
    with case.simulations:
        found = encoder_counts(case)
    assert found is not None
    assert found.values.keys() == {"enc.resolution", "enc.motor_resolution"}


def test_a_twin_without_counts_is_simulated_as_it_is() -> None:
    case = open_small(SERVO.twin(), SERVO.recordings({}, (moves,)))
    with case.simulations:
        assert encoder_counts(case) is None


def test_a_gap_of_the_twin_is_no_encoder_though_it_shuffles_runs_as_well() -> None:
    """Tiny changes let a loose load bounce otherwise, as they let counts fall otherwise."""
    geared = {"gear.flexible": 1.0, "gear.backlash": 0.01}
    twin = FmuTwin(models_folder() / "drive_twin.toml", parameters=geared)
    case = open_small(twin, DRIVE.recordings({}, (moves,)))
    with case.simulations:
        found = encoder_counts(case)
    assert found is not None
    assert found.values.keys() == {"enc.resolution", "enc.motor_resolution"}
