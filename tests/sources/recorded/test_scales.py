"""A motion in a wrong unit or of wrong sign is told, in closed loop as in open loop."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin
from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.contradiction import (
    contradiction,
    refuse_contradictions,
    scale_doubts,
)
from tests.diagnosis.servo_recordings import rewritten
from tests.diagnosis.short_recordings import BENCH, SERVO, moves, multisine, triangle

RPM = 30.0 / np.pi
DEG = 180.0 / np.pi


@pytest.fixture(scope="module")
def servo(tmp_path_factory: pytest.TempPathFactory) -> FmuTwin:
    """The servo, of which the velocity is compared too."""
    more = {"[outputs]\n": '[outputs]\nspeed = "velocity"\n'}
    return rewritten("servo_axis", tmp_path_factory.mktemp("servo"), more)


def with_speed(recording: Recording) -> Recording:
    speed = np.gradient(recording.signal("position"), recording.time)
    return recording.with_signals({"speed": speed})


def scaled(recording: Recording, signal: str, factor: float) -> Recording:
    return recording.with_signals({signal: factor * recording.signal(signal)})


@pytest.fixture(scope="module")
def moved() -> Recording:
    return with_speed(SERVO.recordings({}, [multisine])[0])


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (RPM, "speed is 9.\\d+ times the simulation, as if it were in rpm"),
        (DEG, "speed is 5\\d.* times the simulation, as if it were in deg/s"),
        (0.5 / np.pi, "speed is 0.16\\d* times the simulation, as if it were in rev/s"),
        (-1.0, "speed has the opposite sign of the simulation"),
    ],
)
def test_a_velocity_in_another_unit_is_refused_beside_a_right_position(
    factor: float, words: str, servo: FmuTwin, moved: Recording
) -> None:
    with pytest.raises(RecordingError, match=f"^rec0.csv: {words}"):
        refuse_contradictions(servo, [scaled(moved, "speed", factor)])


def test_a_unit_of_the_twin_file_that_the_header_contradicts_is_refused(
    servo: FmuTwin, moved: Recording
) -> None:
    """Radians that [columns] calls degrees are too small by 57.3: the reference seems too large."""
    note = (
        "rec0.csv: the header of pos says [rad], [columns] of the twin file says deg for position, "
        "which counts; leave unit out there if the header is right"
    )
    small = scaled(moved, "position", 1.0 / DEG)
    with pytest.raises(RecordingError, match=r"reference is .* as if it were in deg"):
        refuse_contradictions(servo, [small])
    with pytest.raises(RecordingError, match=r"leave unit out there.*: it is 0\.017\d* times"):
        refuse_contradictions(servo, [replace(small, notes=(note,))])
    refuse_contradictions(servo, [replace(moved, notes=(note,))])  # control: the twin file is right


def test_control_a_right_velocity_is_not_refused(servo: FmuTwin, moved: Recording) -> None:
    assert contradiction(servo, moved, servo.run({}, moved)) == ""


@pytest.mark.parametrize(
    "physics",
    [
        {"coulomb_friction.level": 2.0},
        {"actuator_gain_loss.loss": 0.5},
        {"transport_delay.delay": 0.01},
        {"actuator_saturation.limit": 0.5},
    ],
)
def test_control_physics_is_no_wrong_unit(physics: dict[str, float], servo: FmuTwin) -> None:
    recorded = SERVO.recordings(physics, (multisine, moves, triangle))
    refuse_contradictions(servo, [with_speed(one) for one in recorded])


@pytest.fixture(scope="module")
def bench() -> Recording:
    return BENCH.recordings({}, [multisine])[0]


def test_an_open_loop_column_in_another_unit_is_a_doubt_and_no_refusal(bench: Recording) -> None:
    with BENCH.twin() as twin:
        wrong = scaled(bench, "position", DEG)
        (told,) = scale_doubts(twin, wrong)
        refuse_contradictions(twin, [wrong])
        assert scale_doubts(twin, bench) == []
    assert told.startswith("rec0.csv: position is 6")
    assert "times the simulation, as if it were in deg; write unit" in told
    assert told.endswith("or a parameter is off by as much")


def test_an_uncertain_parameter_that_explains_the_size_speaks_for_the_axis(
    bench: Recording, tmp_path: Path
) -> None:
    wide = {'"inertia" = [0.0025, 0.01]': '"inertia" = [0.0025, 0.1]'}
    in_turns = scaled(bench, "position", 0.5 / np.pi)
    with BENCH.twin() as twin:
        assert "as if it were in rev" in scale_doubts(twin, in_turns)[0]
    with rewritten("motor_bench", tmp_path, wide) as twin:
        assert scale_doubts(twin, in_turns) == []
