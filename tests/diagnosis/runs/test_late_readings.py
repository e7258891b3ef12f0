"""A recorded position holds what a law adds at the sensor port at that very instant."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.diagnosis.scoring.signal_parts import describe_rig
from tests.diagnosis.noise.planted_noise import opened, planted

LAG = 2e-3  # [s]


def test_a_lagging_sensor_shows_where_the_axis_was() -> None:
    """To the second order of a lag: the position, less its time the velocity, and so on."""
    with opened(planted(1e-9)) as case:
        simulations = case.simulations
        position = describe_rig(case.twin.binding, simulations.records).position
        run = simulations.run_one(Point(physics={"sensor_lag.time": LAG}), 0)
        reading = simulations.reading
    assert position is not None
    assert reading is not None
    assert reading.late == pytest.approx(1.0 / case.substeps)
    states, time = run.response.states, case.simulations.records[0].plan.grid
    q, v = states["position"], states["velocity"]
    acceleration = np.gradient(v, time)
    seen = run.response.held[position]
    expected = q - LAG * v + LAG**2 * acceleration
    inner = slice(20, -20)
    late = seen - expected
    # An error of one physics step would be LAG * step * acceleration.
    share = float(late[inner] @ acceleration[inner] / (acceleration[inner] @ acceleration[inner]))
    assert abs(share) < 0.2 * LAG * time[1] / case.substeps
