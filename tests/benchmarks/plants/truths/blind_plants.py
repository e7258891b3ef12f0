"""Two plants out of the simulator of the blind benchmark (`tests/blind/truth.c`)."""

from __future__ import annotations

from collections.abc import Mapping

from gmfbo.recordings.recording import Recording
from tests.benchmarks.plants.truths.conditions import Conditions, Fallen, Vector
from tests.blind.truth import KINDS, Diverged, simulate

PREROLL = 50
"""Samples before a run; the plants start at rest, and their sensors have no offset."""

SERVO = {
    "kind": KINDS["servo_pd"],
    "inertia": 0.0136,
    "viscous": 0.03,
    "torque_gain": 1.0,
    "torque_lag": 5e-4,
    "filter_time": 1e-3,
    "u_limit": 10.0,
    "friction_positive": 0.35,
    "friction_negative": 0.45,
    "delay": 1.7e-3,
    "quantum": 1e-4,
}
"""Heavier than its twin, with friction, and a bus that is late by 1.7 samples."""

AXIS = {
    "kind": KINDS["axis_pv"],
    "inertia": 120.0,
    "viscous": 280.0,
    "torque_gain": 35.1507,
    "u_limit": 10.0,
    "friction_positive": 22.0,
    "friction_negative": 18.0,
    "drive_lag": 4e-3,
    "quantum": 1e-6,
}
"""Heavier than its twin, with friction, behind a drive with a lag of 4 ms."""

FRICTION = ("friction_positive", "friction_negative")


def _play(
    values: Mapping[str, float],
    gains: Mapping[str, float],
    reference: Recording,
    conditions: Conditions,
    names: tuple[str, str],
    deviation: float,
) -> dict[str, Vector]:
    rubbed = {name: conditions.friction * values[name] for name in FRICTION}
    rubbed["inertia"] = conditions.inertia * values["inertia"]
    wanted = reference.signal("reference")
    noise = conditions.noise(deviation, PREROLL + len(wanted))
    try:
        run = simulate({**values, **rubbed, **gains}, wanted, noise, PREROLL)
    except Diverged as error:
        raise Fallen(str(error)) from error
    position, command = names
    return {
        "time": reference.time,
        "reference": wanted,
        position: run.reading,
        command: run.held,
    }


def servo_axis(
    gains: Mapping[str, float], reference: Recording, conditions: Conditions
) -> dict[str, Vector]:
    """Rotary servo under a PD law."""
    return _play(SERVO, gains, reference, conditions, ("position", "torque_command"), 5e-5)


def linear_axis(
    gains: Mapping[str, float], reference: Recording, conditions: Conditions
) -> dict[str, Vector]:
    """Linear axis under the law of the EMPS rig."""
    return _play(AXIS, gains, reference, conditions, ("position", "drive_voltage"), 2e-5)
