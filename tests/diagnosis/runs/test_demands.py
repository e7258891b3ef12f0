"""What a motion asks of a limit that falls with speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gmfbo.diagnosis.runs.measured_excitation import demands
from gmfbo.physics import CATALOGUE, States
from tests.physics.excitations import TYPICAL

numbers = st.floats(-1e3, 1e3, allow_subnormal=False)


@given(arrays(np.float64, (2, 12), elements=numbers), st.floats(0.0, 50.0))
def test_a_falling_limit_is_met_at_one_of_the_corners(motion: np.ndarray, slope: float) -> None:
    velocity, command = motion
    if max(abs(velocity)) < 1e-3 or max(abs(command)) < 1e-3:
        return
    time = np.arange(12.0)
    states = States(time, np.zeros(12), velocity, command, command, rest=0.0)
    found = demands(states)
    asked = replace(TYPICAL, demands=found).largest_demand(slope)
    met = float(np.max(np.abs(command + slope * velocity)))
    # Corners on the axes give the motion an area: it may ask for its speed, or its command, alone.
    alone = max(slope * max(abs(velocity)), max(abs(command)))
    assert asked == pytest.approx(max(met, alone))
    limit = {"limit": asked, "slope": slope}
    assert not CATALOGUE["supply_voltage_limit"].acts(states, limit).any()


def test_without_a_motion_there_are_none() -> None:
    still = np.zeros(5)
    assert demands(States(np.arange(5.0), still, still, still, still, rest=0.0)) == ()
