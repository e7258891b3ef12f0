"""MATLAB files as Simulink, Dymola and OpenModelica save them; objects, which MATLAB alone reads.

`timeseries_object.mat` was written by mat-io 1.0.2, which writes objects as MATLAB does.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import h5py
import numpy as np
import pytest
import scipy.io
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording, SignalSpec
from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
from gmfbo.recordings.reader import read_columns
from gmfbo.recordings.recording import read_recording
from tests.recordings.twin_words import AXIS, TwinWords

ROWS = 6
TIME = 1e-3 * np.arange(ROWS)
ANGLE, SPEED = np.sin(np.arange(ROWS)), np.cos(np.arange(ROWS))
OBJECT = Path(__file__).parent / "timeseries_object.mat"


def save(folder: Path, content: dict[str, Any]) -> Path:
    path = folder / "run.mat"
    scipy.io.savemat(path, content)
    return path


def texts(lines: list[str], *, transposed: bool) -> NDArray[Any]:
    """A matrix of characters; in binTrans each column is a text."""
    width = max(map(len, lines))
    padded = [line.ljust(width) for line in lines]
    return np.array(["".join(c) for c in zip(*padded, strict=True)] if transposed else padded)


def modelica_result(*, transposed: bool) -> dict[str, Any]:
    """A result file with a constant, a state, its negative, and an event at 2 ms."""
    time = np.insert(TIME, 3, TIME[2])
    angle = np.insert(ANGLE, 3, 7.0)
    names = ["time", "axis.J", "axis.phi", "axis.w", "minus"]
    told = ["Simulation time [s]", "inertia [kg.m2]", "angle [rad|deg]", "[rad/s]", ""]
    info = np.array(
        [[0, 1, 0, -1], [1, 2, 0, 0], [2, 2, 0, 0], [2, 3, 0, 0], [2, -2, 0, 0]], dtype=np.int32
    )
    constants = np.array([[0.0, 0.12], [TIME[-1], 0.12]])
    table = np.column_stack([time, angle, np.insert(SPEED, 3, SPEED[2])])
    kind = ["Atrajectory", "1.1", "", "binTrans" if transposed else "binNormal"]

    def turned(table: NDArray[Any]) -> NDArray[Any]:
        return table.T if transposed else table

    return {
        "Aclass": np.array([line.ljust(11) for line in kind]),
        "name": texts(names, transposed=transposed),
        "description": texts(told, transposed=transposed),
        "dataInfo": turned(info),
        "data_1": turned(constants),
        "data_2": turned(table),
    }


@pytest.mark.parametrize("transposed", [True, False], ids=["binTrans", "binNormal"])
@pytest.mark.parametrize("version", ["4", "5"])
def test_a_result_file_of_dymola_or_openmodelica(
    tmp_path: Path, transposed: bool, version: Literal["4", "5"]
) -> None:
    path = tmp_path / "dsres.mat"
    scipy.io.savemat(path, modelica_result(transposed=transposed), format=version)
    recording = Recording.read(path)
    np.testing.assert_array_equal(recording.time, TIME)
    after_the_event = np.where(np.arange(ROWS) == 2, 7.0, ANGLE)
    np.testing.assert_array_equal(recording.signal("axis.phi"), after_the_event)
    np.testing.assert_array_equal(recording.signal("minus"), -after_the_event)
    np.testing.assert_array_equal(recording.signal("axis.w"), SPEED)
    assert recording.units == {"axis.phi": "rad", "axis.w": "rad/s"}
    assert recording.parameters == {"axis.J": 0.12}


def test_a_result_file_whose_tables_do_not_fit_is_refused(tmp_path: Path) -> None:
    content = modelica_result(transposed=False)
    content["data_2"] = content["data_2"][:, :2]
    with pytest.raises(RecordingError, match=r"one whose tables do not fit .* simulate again"):
        Recording.read(save(tmp_path, content))


@pytest.mark.parametrize("name", ["ans", "log"])
def test_a_to_file_matrix_has_its_time_in_the_first_row(tmp_path: Path, name: str) -> None:
    recording = Recording.read(save(tmp_path, {name: np.vstack([TIME, ANGLE, SPEED])}))
    np.testing.assert_array_equal(recording.time, TIME)
    np.testing.assert_array_equal(recording.signal(f"{name}(2,:)"), ANGLE)


def test_seconds_that_a_matrix_does_not_state_contradict_no_twin_file(tmp_path: Path) -> None:
    path = save(tmp_path, {"m": np.column_stack([1e3 * TIME, ANGLE])})
    file = read_columns(path)
    assert next((c.name, c.unit, c.assumed) for c in file.columns) == ("m(:,1)", "s", True)
    mapping = ColumnMapping({"time": MappedColumn("m(:,1)", unit="ms")})
    recording = read_recording(path, mapping=mapping)
    np.testing.assert_allclose(recording.time, TIME)
    assert recording.notes == ()


def test_a_matrix_beside_its_clock_is_columns(tmp_path: Path) -> None:
    content = {"t": TIME, "y": np.column_stack([ANGLE, SPEED]), "gains": np.ones((2, 3))}
    path = save(tmp_path, content)
    file = read_columns(path)
    np.testing.assert_array_equal(Recording.read(path).signal("y(:,2)"), SPEED)
    # Nothing is hidden: what has another size is there, and says so.
    assert "2 x 3 values, expected 6" in {c.name: c.fault for c in file.columns}["gains"]


def test_a_matrix_whose_first_column_does_not_increase_has_no_clock(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"expected a column 'time'.* y\(:,1\), y\(:,2\)"):
        Recording.read(save(tmp_path, {"y": np.column_stack([ANGLE, SPEED])}))


def test_time_series_of_two_clocks_and_a_vector_with_a_third(tmp_path: Path) -> None:
    content = {
        "position": {"Name": "", "Time": TIME, "Data": ANGLE.reshape(1, 1, ROWS)},
        "speed": {"Name": "speed", "Time": TIME[::2], "Data": SPEED[::2]},
        "tout": TIME,
        "reference": 2 * ANGLE,
        "Kp": 3.0,
    }
    recording = Recording.read(save(tmp_path, content), AXIS)
    np.testing.assert_array_equal(recording.time, TIME)
    np.testing.assert_array_equal(recording.signal("position"), ANGLE)
    np.testing.assert_array_equal(recording.signal("reference"), 2 * ANGLE)
    speed = recording.signal("speed")
    np.testing.assert_array_equal(speed[::2], SPEED[::2])
    assert np.isnan(speed[1::2]).all()


def test_a_short_name_that_two_structures_have_is_not_chosen(tmp_path: Path) -> None:
    """Negative control of `log.position` for `position`."""
    content = {"t": TIME, "a": {"position": ANGLE}, "b": {"position": SPEED}, "reference": ANGLE}
    recording = Recording.read(save(tmp_path, content), AXIS)
    assert "position" not in recording.signals
    assert {"a.position", "b.position"} <= recording.signals.keys()


def test_a_scope_in_a_v73_file_is_an_array_of_structures_by_reference(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    with h5py.File(path, "w", userblock_size=512) as file:

        def put(name: str, value: object, matlab_class: str) -> h5py.Dataset:
            file[name] = value
            file[name].attrs["MATLAB_class"] = np.bytes_(matlab_class)
            return file[name]

        put("Scope/time", TIME.reshape(1, -1), "double")
        for key, items, kind in (
            ("values", (ANGLE.reshape(1, -1), SPEED.reshape(1, -1)), "double"),
            ("label", ([[ord(c)] for c in "position"], [[ord(c)] for c in "speed"]), "char"),
        ):
            targets = [
                put(f"#refs#/{key}{k}", np.array(item, dtype=None), kind)
                for k, item in enumerate(items)
            ]
            file[f"Scope/signals/{key}"] = np.array(
                [[t.ref] for t in targets], dtype=h5py.ref_dtype
            )
    recording = Recording.read(path, TwinWords((SignalSpec("speed", "speed"),)))
    np.testing.assert_array_equal(recording.signal("position"), ANGLE)
    np.testing.assert_array_equal(recording.signal("speed"), SPEED)


def test_a_cell_that_holds_itself_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        cell = file.create_dataset("c", (8, 1), dtype=h5py.ref_dtype)
        cell.attrs["MATLAB_class"] = np.bytes_("cell")
        cell[:] = [[cell.ref]] * 8
    with pytest.raises(RecordingError, match="or one that holds itself"):
        Recording.read(path)


def test_cells_that_hold_each_other_are_refused_and_one_cell_in_two_places_is_read(
    tmp_path: Path,
) -> None:
    path = tmp_path / "run.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"], file["position"] = TIME.reshape(1, -1), ANGLE.reshape(1, -1)
        for name in ("a", "b"):
            cell = file.create_dataset(name, (1, 1), dtype=h5py.ref_dtype)
            cell.attrs["MATLAB_class"] = np.bytes_("cell")
            cell[0, 0] = file["position"].ref
    assert list(Recording.read(path).signals) == ["a(1)", "b(1)", "position"]
    with h5py.File(path, "a") as file:
        file["a"][0, 0], file["b"][0, 0] = file["b"].ref, file["a"].ref
    with pytest.raises(RecordingError, match="or one that holds itself"):
        Recording.read(path)


def test_an_object_of_a_v5_file_is_told_with_the_way_to_export_it() -> None:
    with pytest.raises(RecordingError, match=r"'logsout' is a MATLAB object \(timeseries\).*save"):
        Recording.read(OBJECT)


def test_an_object_of_a_v73_file_stands_among_the_columns(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"], file["position"] = TIME.reshape(1, -1), ANGLE.reshape(1, -1)
        file["logsout"] = np.zeros((1, 6), dtype=np.uint32)
        file["logsout"].attrs["MATLAB_class"] = np.bytes_("Simulink.SimulationData.Dataset")
        file["logsout"].attrs["MATLAB_object_decode"] = np.int32(3)
    faults = {c.name: c.fault for c in read_columns(path).columns}
    assert faults["position"] == ""
    assert "x = logsout.get(1).Values; s.time = x.Time" in faults["logsout"]
    assert list(Recording.read(path).signals) == ["position"]


def test_fields_of_a_table_in_hdf5_are_columns(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    table = np.rec.fromarrays([TIME, ANGLE], names=["time", "position"])  # type: ignore[call-overload]
    with h5py.File(path, "w") as file:
        file["drive/log"] = table
    recording = Recording.read(path)
    np.testing.assert_array_equal(recording.signal("drive/log/position"), ANGLE)
