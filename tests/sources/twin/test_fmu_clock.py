"""FMU time begins at the FMU's own start time; trajectories keep the recording's clock."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, models_folder
from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording

PULSE_AT = 0.5
TWIN = f"""
name = "pulse"
fmu = "physics.fmu"
step = 1e-3
[inputs]
u = "port.torque"
[outputs]
y = "torque"
[parameters]
"pulse_disturbance.start" = {PULSE_AT}
"pulse_disturbance.duration" = 10.0
"pulse_disturbance.level" = 1.0
"""


def physics_from(start: str, tmp_path: Path, more: str = "") -> FmuTwin:
    """physics.fmu, which adds a pulse at a given FMU time, with another default start time."""
    with (
        zipfile.ZipFile(models_folder() / "physics.fmu") as source,
        zipfile.ZipFile(tmp_path / "physics.fmu", "w") as target,
    ):
        for member in source.infolist():
            content = source.read(member)
            if member.filename == "modelDescription.xml":
                content = content.replace(b' startTime="0"', start.encode())
            target.writestr(member, content)
    (tmp_path / "pulse.toml").write_text(TWIN + more)
    return FmuTwin(tmp_path / "pulse.toml")


def recorded(first: float) -> Recording:
    time = first + 1e-3 * np.arange(1000, dtype=np.float64)
    return Recording(time=time, signals={"u": np.zeros(time.size)}, name="rec.csv")


def pulse_after(twin: FmuTwin, first: float) -> float:
    """[s] From the first row to the pulse, which is there one step after it began."""
    with twin:
        run = twin.run({}, recorded(first))
    assert run.status == "ok"
    assert run.time[0] == first
    return float(run.time[np.argmax(run.signal("y") > 0.5)] - first)


@pytest.mark.parametrize("first", [0.0, -3.0, 42.5, 1.766147454e9])
def test_the_clock_of_the_logger_does_not_matter(first: float, tmp_path: Path) -> None:
    twin = physics_from(' startTime="0"', tmp_path)
    assert pulse_after(twin, first) == pytest.approx(PULSE_AT, abs=2e-3)


def test_an_fmu_that_states_no_start_time_begins_at_zero(tmp_path: Path) -> None:
    assert pulse_after(physics_from("", tmp_path), 7.0) == pytest.approx(PULSE_AT, abs=2e-3)


def test_an_fmu_begins_at_the_start_time_that_it_states(tmp_path: Path) -> None:
    twin = physics_from(' startTime="0.3"', tmp_path)
    assert pulse_after(twin, 42.5) == pytest.approx(PULSE_AT - 0.3, abs=2e-3)


def test_the_recorded_time_is_handed_over_on_request(tmp_path: Path) -> None:
    twin = physics_from(' startTime="0"', tmp_path, '[recording]\nclock = "fmu"\n')
    assert pulse_after(twin, 0.1) == pytest.approx(PULSE_AT - 0.1, abs=2e-3)


def test_a_run_beyond_the_limit_is_refused_before_it_takes_memory(tmp_path: Path) -> None:
    long = Recording(time=np.array([0.0, 1e9]), signals={"u": np.zeros(2)}, name="long.csv")
    with (
        physics_from("", tmp_path) as twin,
        pytest.raises(RecordingError, match=r"^long.csv: expected at most 20,000,000 steps"),
    ):
        twin.run({}, long)


def test_the_limit_is_the_twin_files(tmp_path: Path) -> None:
    few = physics_from("", tmp_path, "[limits]\nsteps = 999\n")
    assert pulse_after(few, 0.0) == pytest.approx(PULSE_AT, abs=2e-3)
    less = physics_from("", tmp_path, "[limits]\nsteps = 998\n")
    with less, pytest.raises(RecordingError, match="at most 998 steps of the twin, got 999 for"):
        less.run({}, recorded(0.0))


@pytest.mark.parametrize(
    ("fault", "message"), [(4, "not finite at t = 100.051 s"), (1, "stepping after t = 100.05 s")]
)
def test_a_failure_is_told_by_the_clock_of_the_recording(
    fault: int, message: str, faulty: Path
) -> None:
    late = Recording(
        time=100.0 + 1e-3 * np.arange(101, dtype=np.float64), signals={"reference": np.zeros(101)}
    )
    with FmuTwin(faulty) as twin:
        failed = twin.run({}, late, parameters={"fault": fault, "stage": 2, "at": 0.05})
    assert message in failed.message
    assert failed.stopped_at == pytest.approx(100.05)
