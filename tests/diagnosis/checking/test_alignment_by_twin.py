"""Against the twin, a scale is told where neither its parameters nor what it lacks make it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, check
from gmfbo.diagnosis.checking.text import check_lines
from gmfbo.recordings.recording import Recording
from tests.diagnosis.servo_recordings import rewritten
from tests.diagnosis.short_recordings import BENCH, SERVO

KEPT = ("reference", "position")
PORTS = ('torque = "tau_load"', 'command = "tau_command"', 'sensor = "encoder_offset"')


@pytest.fixture(scope="module")
def tacho(tmp_path_factory: pytest.TempPathFactory) -> FmuTwin:
    """An open-loop motor of which the velocity alone is recorded."""
    folder = tmp_path_factory.mktemp("twin")
    text = BENCH.twin().path.read_text(encoding="utf-8")
    (line,) = [one for one in text.splitlines() if one.startswith("position = ") and "#" in one]
    return rewritten("motor_bench", folder, {line: 'velocity = "velocity"'})


def of_velocity(twin: FmuTwin, inertia: float, viscous: float) -> list[Recording]:
    truth = {"inertia": inertia, "viscous": viscous}
    made = []
    for recording in BENCH.recordings({}, twin=BENCH.twin(), seconds=3.0):
        drive = Recording(time=recording.time, signals={"current": recording.signal("current")})
        velocity = twin.run(truth, drive).signal("velocity")
        noise = 0.02 * np.random.default_rng(3).standard_normal(velocity.size)
        made.append(recording.with_signals({"velocity": velocity + noise}))
    return [
        Recording(r.time, {n: r.signals[n] for n in ("current", "velocity")}, name=r.name)
        for r in made
    ]


@pytest.mark.parametrize(("inertia", "viscous"), [(0.005, 0.01), (0.0065, 0.007)])
def test_a_scale_that_inertia_and_friction_could_make_is_not_told(
    tacho: FmuTwin, inertia: float, viscous: float
) -> None:
    """Of an open-loop motor, both as small by a tenth make its velocity as large by a tenth."""
    recordings = of_velocity(tacho, inertia, viscous)
    seen = check(tacho, recordings, jobs=1)
    assert seen.findings == ()
    assert all(np.isnan(f.alignment["velocity"].scale) for f in seen.recordings.values())
    (row,) = [line for line in check_lines(seen) if line.startswith("velocity ")]
    assert row.split()[-1] == "-"
    for recording in recordings:
        low, high = np.quantile(recording.signal("velocity"), [0.005, 0.995])
        assert seen.recordings[recording.name].speed == pytest.approx((low, high))


def test_a_scale_that_neither_makes_is_told(tmp_path: Path) -> None:
    """Negative control: an axis that follows its reference, and is logged a tenth too large."""
    twin = rewritten("servo_axis", tmp_path, dict.fromkeys(PORTS, ""))
    sound = SERVO.recordings({})
    assert check(twin, sound, jobs=1).findings == ()
    large = [r.with_signals({"position": 1.1 * r.signal("position")}) for r in sound]
    seen = check(twin, large, jobs=1)
    assert {(f.kind, f.signal) for f in seen.findings} == {("scaled_column", "position")}
    assert all("1.1 times" in f.what for f in seen.findings)


def test_an_axis_that_lags_by_physics_is_no_late_column(tmp_path: Path) -> None:
    """A dead time of the drive, that the twin lacks, in a loop whose controller is not seen."""
    twin = rewritten("servo_axis", tmp_path, dict.fromkeys(PORTS, ""))
    late = SERVO.recordings({"transport_delay.delay": 4e-3})
    positions = [replace(r, signals={n: r.signals[n] for n in KEPT}) for r in late]
    kinds = {finding.kind for finding in check(twin, positions, jobs=1).findings}
    assert kinds == {"missing_column"}
