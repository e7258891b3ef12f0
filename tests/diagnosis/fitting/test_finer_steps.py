"""Difference steps that are so long that a law bends within them."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.diagnosis.fitting.difference_steps import with_finer_steps
from gmfbo.diagnosis.fitting.hypothesis import DIFFERENCE_STEP, Candidate, Hypothesis, Setting
from tests.physics.excitations import TYPICAL

HYPOTHESIS = Hypothesis(
    Setting((), TYPICAL), (Candidate("supply_voltage_limit", {"limit": 8.0, "slope": 0.5}),)
)


def test_a_step_that_shows_as_much_as_it_may_stays() -> None:
    assert with_finer_steps(HYPOTHESIS, np.array([20.0, 59.0])) is HYPOTHESIS


def test_a_step_that_shows_ten_times_as_much_is_a_tenth_of_it() -> None:
    found = with_finer_steps(HYPOTHESIS, np.array([200.0, 1.0]))
    steps = found.setting.difference_steps
    assert steps == {"supply_voltage_limit.limit": pytest.approx(0.1 * DIFFERENCE_STEP)}
    again = with_finer_steps(found, np.array([200.0, 1.0]))
    assert again.setting.difference_steps["supply_voltage_limit.limit"] == pytest.approx(
        0.01 * DIFFERENCE_STEP
    )
