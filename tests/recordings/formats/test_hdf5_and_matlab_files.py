"""Plain HDF5 files and MATLAB files of versions 5 and 7.3."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

from gmfbo.recordings import Recording, Trajectory
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.store.example_trials import example_trial
from tests.recordings.twin_words import AXIS

TIME = 1e-3 * np.arange(5.0)


def test_plain_datasets_of_equal_length_are_signals(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file["t"] = 1000 * TIME
        file["t"].attrs["units"] = "ms"
        file["position"] = np.array([0, 90, 180, 270, 360])
        file["position"].attrs["unit"] = "deg"
        file["drive/current"] = np.arange(5.0).reshape(5, 1)
        file["drive/current"].attrs["units"] = np.bytes_("mA")
        file["ctl.Kp"] = 90.0
        file["note"] = "a text"
        file.attrs["ctl.Kd"] = 4
    recording = Recording.read(path)
    np.testing.assert_allclose(recording.time, TIME, rtol=1e-15)
    np.testing.assert_allclose(recording.signal("position"), np.arange(5) * np.pi / 2, rtol=1e-15)
    np.testing.assert_array_equal(recording.signal("drive/current"), np.arange(5) / 1000)
    assert recording.units == {"position": "rad", "drive/current": "A"}
    assert recording.parameters == {"ctl.Kp": 90.0, "ctl.Kd": 4.0}


@pytest.mark.parametrize("shape", [(5,), (5, 1), (1, 5)])
def test_vectors_of_a_v5_file_may_lie_either_way(tmp_path: Path, shape: tuple[int, ...]) -> None:
    path = tmp_path / "run.mat"
    content = {"t": TIME, "q": np.arange(5, dtype=np.int16), "kp": 160.18, "label": "x"}
    scipy.io.savemat(
        path, {n: v.reshape(shape) if isinstance(v, np.ndarray) else v for n, v in content.items()}
    )
    recording = Recording.read(path)
    np.testing.assert_array_equal(recording.time, TIME)
    np.testing.assert_array_equal(recording.signal("q"), np.arange(5))
    assert recording.parameters == {"kp": 160.18}


def test_fields_of_a_matlab_structure_are_named_with_a_point(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"log": {"time": TIME, "pos": 2 * TIME, "drive": {"iq": 3 * TIME}}})
    recording = Recording.read(path)
    assert list(recording.signals) == ["log.pos", "log.drive.iq"]


def test_a_v73_file_is_read_like_a_v5_file(tmp_path: Path) -> None:
    """Laid out as MATLAB does: a 512-byte head, arrays transposed, classes as attributes."""
    path = tmp_path / "run.mat"
    with h5py.File(path, "w", userblock_size=512) as file:

        def put(name: str, value: object, matlab_class: str) -> None:
            file[name] = value
            file[name].attrs["MATLAB_class"] = np.bytes_(matlab_class)

        put("t", TIME.reshape(1, 5), "double")
        put("log/q", np.arange(5, dtype=np.int32).reshape(1, 5), "int32")
        put("kp", [[160.18]], "double")
        put("label", np.array([[120], [121]], dtype=np.uint16), "char")
        put("nothing", np.zeros(2, dtype=np.uint64), "double")
        file["nothing"].attrs["MATLAB_empty"] = 1
        file["#refs#/a"] = np.arange(3.0)
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    recording = Recording.read(path)
    np.testing.assert_array_equal(recording.time, TIME)
    assert list(recording.signals) == ["log.q"]
    assert recording.parameters == {"kp": 160.18}


def test_a_trial_of_a_study_is_a_recording_of_ours(tmp_path: Path) -> None:
    with StudyStore.create(tmp_path / "a.study", "") as store:
        trial = example_trial(3)
        path = store.write_trial(trial)
    recording = Recording.read(path, AXIS)
    assert isinstance(recording, Trajectory)
    assert recording.written_by == "0.1.0"
    np.testing.assert_array_equal(recording.signal("position"), trial.recording.signal("position"))
    assert recording.parameters == {"ctl.Kp": trial.gains["ctl.Kp"], "mech.J": 0.12}
    # This twin has no parameter of that name, so its schedule is a column like others.
    assert set(recording.signals) == {"reference", "position", "torque_command", "mot.kt"}
