"""The EMPS benchmark's file, as it was published (Janot, Gautier, Brunot 2019)."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from gmfbo.recordings import Recording, SignalSpec
from gmfbo.recordings.writing.writer import write_recording
from tests.recordings.twin_words import TwinWords

FILE = Path(os.environ.get("GMFBO_DATA", "")) / "emps" / "DATA_EMPS.mat"
WORDS = TwinWords(
    signals=(
        SignalSpec("reference", "qg", unit="m", required=True),
        SignalSpec("position", "qm", unit="m", required=True),
        SignalSpec("force", "vir", scale=35.15065188248547, scaled=True, unit="N"),
    ),
    parameters={"kp": True, "kv": True},
)
pytestmark = pytest.mark.skipif(
    "GMFBO_DATA" not in os.environ or not FILE.exists(),
    reason="needs DATA_EMPS.mat of nonlinearbenchmark.org in the folder emps of $GMFBO_DATA",
)


def test_the_signals_are_those_of_the_file(tmp_path: Path) -> None:
    raw = scipy.io.loadmat(FILE)
    recording = Recording.read(FILE, WORDS)
    assert len(recording) == 24841
    np.testing.assert_array_equal(recording.time, raw["t"][:, 0])
    np.testing.assert_array_equal(recording.signal("position"), raw["qm"][:, 0])
    np.testing.assert_array_equal(recording.signal("force"), raw["vir"][:, 0] * raw["gtau"][0, 0])
    assert recording.units == {"reference": "m", "position": "m", "force": "N"}
    assert recording.parameters == {"kp": raw["kp"][0, 0], "kv": raw["kv"][0, 0]}
    for ending in (".csv", ".h5"):
        copy = Recording.read(write_recording(recording, tmp_path / f"emps{ending}"), WORDS)
        np.testing.assert_array_equal(copy.signal("force"), recording.signal("force"))


def test_the_published_controller_reproduces_the_recorded_drive_input() -> None:
    """vir = kv (kp (qg - qm) - dq), dq the difference of the two-tap mean of qm."""
    recording = Recording.read(FILE)
    position = recording.signal("qm")
    mean = 0.5 * (position[1:] + position[:-1])
    speed = np.diff(mean) / np.diff(recording.time)[1:]
    error = recording.signal("qg")[2:] - position[2:]
    kp, kv = recording.parameters["kp"], recording.parameters["kv"]
    drive_input = recording.signal("vir")[2:]
    residual = kv * (kp * error - speed) - drive_input
    assert np.linalg.norm(residual) / np.linalg.norm(drive_input) < 0.005
