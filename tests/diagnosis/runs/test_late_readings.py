"""A recorded position holds what a law adds at the sensor port at that very instant."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from gmfbo.diagnosis.runs.logging_convention import shows_late
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.diagnosis.scoring.signal_parts import describe_rig
from tests.diagnosis.noise.planted_noise import opened, planted

LAG = 2e-3  # [s]


@pytest.mark.parametrize("to_si", [1.0, 1e-3, np.pi / 180.0])
@pytest.mark.parametrize(("rows", "is_late"), [(0, False), (1, True), (None, False)])
def test_a_column_is_late_where_it_shows_the_port_a_row_after(
    to_si: float, rows: int | None, is_late: bool
) -> None:
    """Whatever its unit; None is a plant's column, which a loop moves slowly."""

    def run_one(point: Point, k: int, excitation: Any = None) -> Any:
        pushed = np.zeros(50) if excitation is None else excitation["sensor"]
        loop = -0.05 * np.cumsum(pushed)
        shown = 0.0 if rows is None else np.concatenate([np.zeros(rows), pushed])[:50]
        held = {"position": to_si * (np.linspace(0.0, 3.0, 50) + loop + shown)}
        return SimpleNamespace(response=SimpleNamespace(held=held, ports={"sensor": pushed}))

    record = SimpleNamespace(plan=SimpleNamespace(grid=np.arange(50.0)))
    simulations = cast(Any, SimpleNamespace(run_one=run_one, records=[record]))
    assert shows_late(simulations, "position", to_si) is is_late


def test_a_lagging_sensor_shows_where_the_axis_was() -> None:
    """To the second order of a lag: the position, less its time the velocity, and so on."""
    with opened(planted(1e-9)) as case:
        simulations = case.simulations
        position = describe_rig(case.twin.binding, case.twin.file.outputs).position
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
