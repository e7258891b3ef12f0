"""A value that the twin holds fixed and that is wrong is told, with the line that sets it."""

from __future__ import annotations

import json

from gmfbo import diagnose
from gmfbo.physics import CATALOGUE
from tests.diagnosis.short_recordings import Axis, moves, multisine, triangle

FILTER_TIME = 1.6e-3
"""[s] Of the axis' controller; the twin has 1 ms."""

RIVALS = {"sensor_lag", "actuator_lag", "transport_delay", "coulomb_friction"}


def test_a_wrong_filter_time_is_told_as_such_and_not_as_a_lag() -> None:
    axis = Axis(truth={**Axis().truth, "filter_time": FILTER_TIME})
    recordings = axis.recordings({}, (multisine, moves, triangle))
    others = [name for name in CATALOGUE if name not in RIVALS]
    found = diagnose(axis.twin(), recordings, exclude=others, jobs=1)
    told = json.loads(found.to_json())
    assert told["verdict"] == "parameters"
    assert not told["effects"]
    value = told["parameters"]["filter_time"]
    assert value["fixed"]
    assert value["low"] <= FILTER_TIME <= value["high"]
    where = "(fixed in the FMU; [parameters] of servo_axis.toml sets it"
    assert "filter_time is 0.0015" in found.sentence or "filter_time is 0.0016" in found.sentence
    assert f"instead of 0.001 {where}" in found.sentence
