"""Sizes that would show are those of a diagnosis, and add up over recordings."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest

from gmfbo import check, diagnose
from gmfbo.diagnosis import Check
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import SERVO_NOISE, Axis, multisine

LIMITS = {"actuator_saturation", "actuator_rate_limit", "supply_voltage_limit"}
"""They show whole or not at all, from the next of a few starts that refitted parameters move."""

NULL = Axis(truth={"inertia": 0.01, "viscous": 0.05})


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    return NULL.recordings({})


@pytest.fixture(scope="module")
def seen(recordings: list[Recording]) -> Check:
    return check(NULL.twin(), recordings)


@pytest.mark.slow
def test_they_agree_with_what_a_diagnosis_reports_as_detectable(
    seen: Check, recordings: list[Recording]
) -> None:
    diagnosis = diagnose(NULL.twin(), recordings)
    assert diagnosis.verdict == "none"
    assert set(seen.showable) == set(diagnosis.detectable)
    for name, size in diagnosis.detectable.items():
        assert seen.showable[name].parameter == size.parameter
        assert seen.showable[name].unit == size.unit
        if name not in LIMITS:
            assert 1 / 1.1 < seen.showable[name].together / size.size < 1.1, name
    silent = {entry.name for entry in seen.not_testable}
    assert silent == {entry.name for entry in diagnosis.not_testable}


def test_all_recordings_together_show_at_least_what_each_shows_alone(seen: Check) -> None:
    for size in seen.showable.values():
        assert size.together >= size.floor
        assert all(size.together <= alone * (1.0 + 1e-9) for alone in size.alone.values())


@pytest.mark.slow
def test_twice_the_recordings_show_what_is_smaller_by_the_root_of_two() -> None:
    # Noise is told as the same of the same rows; there is so much of it that sizes are no floors.
    loud = replace(NULL, noise={name: 40.0 * sigma for name, sigma in SERVO_NOISE.items()})
    once = loud.recordings({}, (multisine, multisine), seconds=2.6)
    again = [replace(one, name=f"again {one.name}") for one in once]
    few, many = check(loud.twin(), once), check(loud.twin(), [*once, *again])
    above = [
        name
        for name, size in few.showable.items()
        if size.together > 1.5 * size.floor and name not in LIMITS
    ]
    assert {"coulomb_friction", "backlash", "quadratic_drag"} <= set(above)
    ratios = [few.showable[name].together / many.showable[name].together for name in above]
    assert ratios == pytest.approx([math.sqrt(2.0)] * len(above), rel=0.01)


def test_what_no_size_would_show_has_none(seen: Check) -> None:
    # The loop follows a reading that is off by any offset, and the axis stands elsewhere.
    why = {entry.name: entry.why for entry in seen.not_testable}
    assert "no size" in why["sensor_offset"]
    assert not set(why) & set(seen.showable)


def test_the_json_holds_every_number_and_null_for_none(seen: Check) -> None:
    content = json.loads(seen.to_json())
    assert content["schema"] == 1
    size = content["showable"]["coulomb_friction"]
    assert size["together"] == seen.showable["coulomb_friction"].together
    assert size["alone"]["rec0.csv"] == seen.showable["coulomb_friction"].alone["rec0.csv"]
    assert content["recordings"]["rec0.csv"]["columns"]["position"]["steps"] is None
    response = next(r for r in content["responses"] if r["signal"] == "position")
    assert len(response["frequency"]) == len(response["gain"]) == len(response["coherence"])
