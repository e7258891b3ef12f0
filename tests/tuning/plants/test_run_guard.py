"""The abort in the plant's own process, on a real FMU that a program plays."""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gmfbo.errors import InputError
from gmfbo.objective.envelope import Envelope
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.plants.heartbeat import LOST_AFTER_S, beating
from gmfbo.sources.plants.run_guard import RunGuard
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner

TWIN = json.dumps((models_folder() / "linear_axis.toml").as_posix())
PROGRAM = f"""
import sys, json
from dataclasses import replace
from gmfbo import FmuTwin, Recording, write_recording
from gmfbo.sources.plants.run_guard import RunGuard
request = sys.argv[sys.argv.index("--request") + 1]
asked = json.load(open(request))
guard = RunGuard.read(request)
with FmuTwin({TWIN}, isolated=False) as axis:
    run = axis.run(asked["gains"], Recording.read(asked["reference"]))
last = run.time.size
for row, t in enumerate(run.time):
    if guard.check(t, {{"drive_voltage": run.signal("drive_voltage")[row]}}):
        last = row + 1
        with open("aborted.jsonl", "a") as file:
            print(json.dumps([asked["gains"], guard.safe_gains, guard.reason]), file=file)
        break
signals = {{name: values[:last] for name, values in run.signals.items()}}
told = replace(run, time=run.time[:last], signals=signals,
               parameters={{**asked["gains"], **guard.parameters}})
write_recording(told, asked["out"])
"""
STUDY = f"""
name = "guarded"
method = "random"
[is1]
command = [{json.dumps(sys.executable)}, "program.py"]
[is2]
twin = {TWIN}
[gains]
kp = {{ low = 40.0, high = 320.0, now = 60.0 }}
kv = {{ low = 60.0, high = 500.0, now = 120.0 }}
[reference]
step = 2e-4
at = 0.05
horizon = 0.2
[objective]
as_published = true
[safety]
drive_voltage = [-VOLTS, VOLTS]
[budget]
initial_is1 = 2
iterations = 2
"""


def tuned(folder: Path, volts: float) -> tuple[list[tuple[str, str, int]], list[list[Any]]]:
    """Status, message and rows of each real run, and what the program aborted."""
    folder.mkdir(exist_ok=True)
    (folder / "program.py").write_text(PROGRAM, encoding="utf-8")
    text = STUDY.replace("VOLTS", str(volts))
    (folder / "guarded.toml").write_text(text, encoding="utf-8")
    with Tuner(Study.read(folder / "guarded.toml")) as tuner:
        tuner.run()
        real = tuner.history.of("IS1")
    runs = [
        (trial.status, getattr(trial.recording, "message", ""), trial.recording.time.size)
        for trial in real
    ]
    log = folder / "aborted.jsonl"
    lines = log.read_text().splitlines() if log.exists() else []
    return runs, [json.loads(line) for line in lines]


@pytest.mark.slow
def test_the_program_aborts_and_tells_its_latency_and_knows_the_last_safe_gains(
    tmp_path: Path,
) -> None:
    runs, aborted = tuned(tmp_path, 2.0)
    unsafe = [(message, rows) for status, message, rows in runs if status == "unsafe"]
    assert runs[0][0] == "ok"
    assert unsafe
    assert len(aborted) == len(unsafe)
    for message, rows in unsafe:
        assert message.startswith("left the safety envelope at 0.05")
        assert "the plant's own abort came" in message
        assert "ms after its sample" in message
        assert rows < runs[0][2]
    for _, safe, reason in aborted:
        assert set(safe) == {"kp", "kv"}
        assert reason.startswith("left the safety envelope: drive_voltage")
    assert aborted[0][1] == {"kp": 60.0, "kv": 120.0}


@pytest.mark.slow
def test_control_a_run_inside_the_envelope_is_not_aborted(tmp_path: Path) -> None:
    runs, aborted = tuned(tmp_path, 500.0)
    assert {status for status, *_ in runs} == {"ok"}
    assert aborted == []


def test_a_heartbeat_that_stops_ends_the_run(tmp_path: Path) -> None:
    beat = tmp_path / "heartbeat"
    guard = RunGuard(Envelope(), heartbeat=beat, lost_after_s=LOST_AFTER_S)
    with beating(beat):
        assert guard.check(0.0, {"position": 1.0}) == ""
        first = beat.stat().st_mtime
        time.sleep(0.7)
        assert beat.stat().st_mtime > first  # it beats by itself
    assert guard.parameters == {}
    old = time.time() - 2.0 * LOST_AFTER_S
    os.utime(beat, (old, old))
    assert guard.check(0.1, {"position": 1.0}).startswith("no heartbeat for 2 s")
    assert set(guard.parameters) == {"abort_latency_s"}


def test_the_latency_counts_from_the_sample(tmp_path: Path) -> None:
    guard = RunGuard(Envelope({"position": (-1.0, 1.0)}))
    assert guard.check(0.0, {"position": 0.5}, taken=time.perf_counter() - 20.0) == ""
    assert guard.latency_s == pytest.approx(20.0, abs=10.0)  # a busy machine takes its time
    assert "position = 2 outside [-1, 1]" in guard.check(0.1, {"position": 2.0})
    # A blank is not outside.
    assert RunGuard(Envelope({"position": (-1.0, 1.0)})).check(0.0, {"position": np.nan}) == ""


def test_a_file_that_is_no_request_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "other.json").write_text("[1]")
    with pytest.raises(InputError, match="expected the file that gmfbo names by --request"):
        RunGuard.read(tmp_path / "other.json")
