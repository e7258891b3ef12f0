"""A gain that recordings state wrongly: the command shows it, and no physics is named for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from gmfbo.diagnosis.checking.shown_gains import ShownGain, find_shown_gain
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import (
    SERVO,
    SERVO_GAINS,
    diagnosed,
    moves,
    multisine,
    named,
    triangle,
)

FRICTION = {"coulomb_friction.level": 0.25, "coulomb_friction.deflection": 1e-6}
LAWS = ("coulomb_friction", "actuator_lag", "transport_delay")
REFERENCES = (multisine, moves, triangle)


def stating(recordings: Sequence[Recording], **ratios: float) -> list[Recording]:
    """The same recordings, which state other gains than were in force."""
    wrong = {name: SERVO_GAINS[name] * ratio for name, ratio in ratios.items()}
    return [replace(r, parameters={**r.parameters, **wrong}) for r in recordings]


def shown(recordings: Sequence[Recording]) -> ShownGain | None:
    with SERVO.twin() as twin:
        return find_shown_gain(twin, recordings, seed=0, jobs=1)


@pytest.mark.parametrize("ratio", [0.9, pytest.param(1.05, marks=pytest.mark.slow)])
def test_a_wrong_gain_is_measured_by_the_command(ratio: float) -> None:
    found = shown(stating(SERVO.recordings(FRICTION, REFERENCES), kp=ratio))
    assert found is not None
    assert found.name == "kp"
    assert found.ratio == pytest.approx(1.0 / ratio, rel=0.01)


def test_right_gains_are_left_alone_whatever_is_missing() -> None:
    """Negative control: friction is not in the controller."""
    assert shown(SERVO.recordings(FRICTION, REFERENCES)) is None


def test_a_column_that_is_scaled_is_no_gain() -> None:
    """Negative control: position and command go wrong together only by a gain."""
    found = []
    for r in SERVO.recordings(FRICTION, REFERENCES):
        scaled = dict(r.signals, torque_command=1.05 * r.signal("torque_command"))
        found.append(replace(r, signals=scaled))
    assert shown(found) is None


def test_each_recording_keeps_its_own_gain_times_the_ratio() -> None:
    first, second = SERVO.recordings({}, (multisine, moves))
    other = replace(second, parameters={**second.parameters, "kp": 60.0})
    silent = replace(second, parameters={})
    changed = ShownGain("kp", 30.0, 0.5).put_in([first, other, silent])
    assert [r.parameters["kp"] for r in changed] == [20.0, 30.0, 15.0]
    assert changed[0].parameters["kd"] == SERVO_GAINS["kd"]


def of(recordings: Sequence[Recording]) -> Diagnosis:
    return diagnosed(SERVO.twin(), recordings, only=LAWS)


@pytest.mark.slow
def test_a_wrong_gain_makes_no_physics() -> None:
    assert named(of(stating(SERVO.recordings({}, REFERENCES), kp=1.05))) == []


@pytest.mark.slow
def test_a_wrong_gain_hides_no_physics() -> None:
    friction = of(stating(SERVO.recordings(FRICTION, REFERENCES), kp=1.05))
    assert named(friction) == ["coulomb_friction"]
    assert any("shows that kp was 0.95" in note for note in friction.notes)
    level = friction.effects[0].parameters["level"].value
    assert level == pytest.approx(FRICTION["coulomb_friction.level"], rel=0.03)
