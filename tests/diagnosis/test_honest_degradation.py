"""Few, short, blank, noiseless or odd recordings: the diagnosis says less rather than wrong."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import diagnose
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.errors import InputError, RecordingError
from gmfbo.physics import CATALOGUE
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.models import models_folder
from tests.diagnosis.servo_recordings import certain
from tests.diagnosis.short_recordings import (
    QUIET_SERVO,
    SERVO,
    Axis,
    climb,
    decided,
    diagnosed,
    multisine,
    named,
    open_small,
)

FRICTION = {"coulomb_friction.level": 0.25, "coulomb_friction.deflection": 1e-6}
FEW = ("coulomb_friction", "viscous_friction", "constant_torque_offset", "transport_delay")
LAWS = [name for name, effect in CATALOGUE.items() if effect.family == "friction"]


def finds_friction(diagnosis: Diagnosis, within: float = 0.02) -> bool:
    assert diagnosis.verdict == "missing_physics"
    assert named(diagnosis) == ["coulomb_friction"]
    level = diagnosis.effects[0].parameters["level"].value
    return abs(level / 0.25 - 1.0) < within


def decides_on_friction(recordings: Sequence[Recording], within: float = 0.02) -> bool:
    """The same of the decision alone, without what is reported of it."""
    with closing((case := open_small(SERVO.twin(), recordings)).simulations):
        (only,) = decided(case, FEW).rounds
    assert only.winner.name == "coulomb_friction"
    return abs(only.winner.effect.values["level"] / 0.25 - 1.0) < within


def from_row(recording: Recording, first: int) -> Recording:
    return replace(
        recording,
        time=recording.time[first:],
        signals={name: column[first:] for name, column in recording.signals.items()},
    )


def at_a_quarter_of_the_rate(recording: Recording) -> Recording:
    position = recording.signals["position"].copy()
    position[np.arange(position.size) % 4 != 0] = np.nan
    return recording.with_signals({"position": position})


def with_lost_rows(recording: Recording) -> Recording:
    """40 rows on end, and one."""
    lost = {n: recording.signals[n].copy() for n in ("position", "torque_command")}
    for column in lost.values():
        column[300:340], column[700] = np.nan, np.nan
    return recording.with_signals(lost)


def without_command(recording: Recording) -> Recording:
    signals = {n: c for n, c in recording.signals.items() if n != "torque_command"}
    return replace(recording, signals=signals)


def test_one_recording_of_the_position_alone_tells_plain_friction() -> None:
    recordings = SERVO.recordings(FRICTION, (multisine,), signals=["position"])
    diagnosis = diagnosed(SERVO.twin(), recordings, only=FEW)
    assert finds_friction(diagnosis)
    assert diagnosis.fit.held_out
    assert list(diagnosis.fit.signals) == ["position"]


def test_lost_rows_blank_cells_and_a_missing_signal_do_no_harm() -> None:
    """A line across 40 lost rows is no motion: taken for one, friction was 7 % off."""
    first, second = SERVO.recordings(FRICTION)
    spoilt = with_lost_rows(at_a_quarter_of_the_rate(first))
    assert decides_on_friction([spoilt, without_command(second)])


@pytest.mark.slow
@pytest.mark.parametrize("spoil", [at_a_quarter_of_the_rate, with_lost_rows, without_command])
def test_each_kind_of_gap_alone_does_no_harm(spoil: Callable[[Recording], Recording]) -> None:
    first, second = SERVO.recordings(FRICTION)
    both = spoil is not without_command  # one has to hold the command
    assert decides_on_friction([spoil(first) if both else first, spoil(second)])


@pytest.mark.parametrize("logged", ["held", pytest.param("new", marks=pytest.mark.slow)])
def test_an_unknown_loggers_convention_is_found(logged: str) -> None:
    new = ["torque_command"] if logged == "new" else []
    recordings = SERVO.recordings(FRICTION, (multisine,), written_by="", logged_new=new)
    diagnosis = diagnosed(SERVO.twin(), recordings, only=FEW)
    assert diagnosis.alignment["torque_command"].logged == logged
    assert diagnosis.alignment["position"].logged == "held"
    assert abs(diagnosis.alignment["torque_command"].shift) < 3e-4
    assert finds_friction(diagnosis)


@pytest.mark.slow
def test_a_start_in_motion_is_scored_once_it_is_forgotten() -> None:
    whole = SERVO.recordings(FRICTION, seconds=1.9)
    recordings = [from_row(recording, 400) for recording in whole]
    diagnosis = diagnosed(SERVO.twin(), recordings, only=FEW)
    assert finds_friction(diagnosis, within=0.05)
    assert diagnosis.parameters["inertia"].value == pytest.approx(0.0105, rel=0.03)
    assert diagnosis.alignment["torque_command"].scale == pytest.approx(1.0, abs=0.03)


def test_a_climb_without_reversals_is_insufficient_and_friction_is_not_excited() -> None:
    recordings = SERVO.recordings({}, (climb,))
    diagnosis = diagnosed(SERVO.twin(), recordings, only=FEW[:1])
    assert diagnosis.verdict in ("none", "parameters")
    assert diagnosis.evidence == "insufficient"
    why = {entry.name: entry.why for entry in diagnosis.not_testable}
    assert why["coulomb_friction"].startswith("not excited: ")


@pytest.mark.slow
def test_an_assumed_effect_is_tested_where_the_recordings_seem_not_to_show_it() -> None:
    recordings = SERVO.recordings(FRICTION, (climb,))
    others = [name for name in CATALOGUE if name not in FEW[:1]]
    diagnosis = diagnose(
        SERVO.twin(), recordings, assume=["coulomb_friction"], exclude=others, jobs=1
    )
    assert "coulomb_friction" not in [entry.name for entry in diagnosis.not_testable]
    assert "coulomb_friction" in named(diagnosis)


@pytest.mark.slow
def test_without_noise_friction_is_exact_and_nothing_else_is_named() -> None:
    assert decides_on_friction(QUIET_SERVO.recordings(FRICTION), within=0.01)


def test_without_noise_a_perfect_twin_lacks_nothing() -> None:
    perfect = Axis(truth={}, noise={})
    diagnosis = diagnosed(SERVO.twin(), perfect.recordings({}), only=FEW)
    assert diagnosis.verdict == "none"


@pytest.mark.parametrize(
    "axis",
    [
        pytest.param(SERVO, id="noisy", marks=pytest.mark.slow),
        pytest.param(QUIET_SERVO, id="silent"),
    ],
)
def test_an_axis_at_rest_tells_nothing_and_is_said_to(axis: Axis) -> None:
    diagnosis = diagnosed(SERVO.twin(), axis.recordings({}, (np.zeros_like, np.zeros_like)))
    assert (diagnosis.verdict, diagnosis.evidence) == ("none", "insufficient")
    for estimate in diagnosis.parameters.values():
        assert not estimate.identifiable
        assert estimate.value == estimate.nominal
    why = {entry.name: entry.why for entry in diagnosis.not_testable}
    assert why["transport_delay"] == "changes nothing in these recordings"
    assert why["coulomb_friction"] == "not excited: no reversal of the velocity"
    json.loads(diagnosis.to_json())


@pytest.mark.slow
def test_at_rest_no_effect_is_said_to_be_a_parameter(tmp_path: Path) -> None:
    """Nor where the twin has no parameter left to refit."""
    twin = certain("servo_axis", tmp_path)
    diagnosis = diagnosed(twin, QUIET_SERVO.recordings({}, (np.zeros_like,)))
    assert diagnosis.verdict == "none"
    why = {entry.name: entry.why for entry in diagnosis.not_testable}
    assert why["transport_delay"] == "changes nothing in these recordings"


def test_a_recording_of_50_rows_is_refused_in_one_line() -> None:
    recordings = SERVO.recordings({}, seconds=0.05)
    with pytest.raises(RecordingError, match=r"^rec0\.csv: expected at least 64 rows") as error:
        diagnosed(SERVO.twin(), recordings)
    assert "\n" not in str(error.value)


def test_no_recording_is_refused() -> None:
    with pytest.raises(RecordingError, match="expected at least one recording, got none"):
        diagnosed(SERVO.twin(), [])


def test_an_effect_that_is_not_in_the_catalogue_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match=r"no effect 'coulomb'.*coulomb_friction"):
        diagnose(SERVO.twin(), SERVO.recordings({}), exclude=["coulomb"])


@pytest.mark.slow
def test_without_any_friction_law_none_of_the_others_is_named_with_confidence() -> None:
    """Placebo: the true effect is out of the library, with all laws that contain it."""
    diagnosis = diagnose(SERVO.twin(), SERVO.recordings(FRICTION), exclude=LAWS, jobs=1)
    assert not set(LAWS) & set(named(diagnosis))
    assert all(effect.probability < 0.5 for effect in diagnosis.effects)


def content(diagnosis: Diagnosis) -> dict[str, object]:
    """All of diagnosis.json but the time it took."""
    text: dict[str, object] = json.loads(diagnosis.to_json())
    cost = text["cost"]
    assert isinstance(cost, dict)
    for name in ("seconds", "stages"):
        cost.pop(name, None)
    return text


@pytest.mark.slow
def test_the_same_seed_gives_the_same_diagnosis_whatever_the_number_of_jobs() -> None:
    recordings = SERVO.recordings(FRICTION, seconds=1.0)
    one, two = (
        content(diagnosed(SERVO.twin(), recordings, only=FEW[:1], jobs=jobs)) for jobs in (1, 2)
    )
    assert one == two


def written(recordings: Sequence[Recording], folder: Path) -> list[Path]:
    paths = []
    for recording in recordings:
        columns: dict[str, NDArray[np.float64]] = {"time": recording.time, **recording.signals}
        head = [f"# {name} = {value}" for name, value in recording.parameters.items()]
        rows = [
            ",".join(repr(float(v)) for v in row) for row in zip(*columns.values(), strict=True)
        ]
        path = folder / recording.name
        path.write_text("\n".join([*head, ",".join(columns), *rows]) + "\n")
        paths.append(path)
    return paths


def session(leader: int) -> list[int]:
    """Processes of a session that are alive, by the kernel's table."""
    alive = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == leader and fields[0] != "Z":
            alive.append(int(entry.name))
    return alive


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs the table in /proc")
def test_ctrl_c_ends_a_diagnosis_with_all_its_processes_and_writes_nothing(tmp_path: Path) -> None:
    recordings = written(SERVO.recordings(FRICTION, seconds=2.5), tmp_path)
    out = tmp_path / "out"
    command = "import sys; from gmfbo.cli import main; sys.exit(main(sys.argv[1:]))"
    twin = models_folder() / "servo_axis.toml"
    arguments = ["diagnose", twin, *recordings, "--out", out, "--jobs", "2"]
    with subprocess.Popen(
        [sys.executable, "-c", command, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        deadline = time.monotonic() + 30.0
        while len(session(process.pid)) < 3 and time.monotonic() < deadline:
            time.sleep(0.05)
        assert len(session(process.pid)) >= 3, "its simulators did not start"
        os.kill(process.pid, signal.SIGINT)
        _, said = process.communicate(timeout=30.0)
    assert process.returncode == 130
    assert said.startswith("gmfbo: interrupted")
    assert said.count("\n") == 1
    deadline = time.monotonic() + 5.0
    while session(process.pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert session(process.pid) == []
    assert list(out.iterdir()) == []
