"""Steps that drive the axis into a limit say nothing wrong of the loop, nor of its speed."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.physics import Excitation
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import SERVO, moves, open_small

Array = NDArray[np.float64]
LIMIT = {"supply_voltage_limit.limit": 6.0, "supply_voltage_limit.slope": 0.4}


def steps(t: Array) -> Array:
    """To and fro by half a turn every half second: the drive is at its limit for a while."""
    return np.where(t % 1.0 < 0.5, 3.0, -3.0) * (t > 0.05)


def long_steps(t: Array) -> Array:
    return 4.0 * steps(t)


def excitation(recorded: list[Recording]) -> Excitation:
    with closing((case := open_small(SERVO.twin(), recorded)).simulations):
        return case.setting.excitation


def test_the_time_of_a_loop_is_no_longer_where_the_drive_meets_its_limit() -> None:
    small = excitation(SERVO.recordings({}, (moves,))).loop_time
    limited = excitation(SERVO.recordings({}, (steps,), seconds=2.9)).loop_time
    assert limited == pytest.approx(small, rel=0.5)


def test_laws_are_scaled_by_the_speed_of_the_axis_and_not_of_a_faster_twin() -> None:
    recorded = SERVO.recordings(LIMIT, (long_steps,), seconds=2.9)
    moved = np.abs(np.gradient(recorded[0].signals["position"], recorded[0].time))
    unlimited = SERVO.recordings({}, (long_steps,), seconds=2.9)[0]
    faster = np.abs(np.gradient(unlimited.signals["position"], unlimited.time))
    assert faster.max() > 1.5 * moved.max()
    assert excitation(recorded).speed == pytest.approx(np.quantile(moved, 0.995), rel=0.1)
