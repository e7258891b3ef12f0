"""Numbers at the edge: NaN, infinity, denormal, constant, one sample, millions of samples."""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording
from gmfbo.recordings.csv.large_table import LARGE_BYTES
from tests.recordings.twin_words import AXIS

ROWS = 200
TIME = 1e-3 * np.arange(ROWS, dtype=np.float64)


def write(folder: Path, ending: str, values: NDArray[np.float64]) -> Path:
    path = folder / f"run{ending}"
    if ending == ".csv":
        rows = [f"{t!r},1.0,{float(v)!r}" for t, v in zip(TIME.tolist(), values, strict=True)]
        path.write_text("\n".join(["time,reference,position", *rows, ""]), encoding="utf-8")
    else:
        with h5py.File(path, "w") as file:
            file["time"], file["position"], file["reference"] = TIME, values, np.ones(ROWS)
    return path


@pytest.mark.parametrize("ending", [".csv", ".h5"])
@pytest.mark.parametrize("value", [np.nan, 5e-324, -5e-324, 0.0, 0.5, 1e99, -1e99])
def test_constant_signals_are_read(tmp_path: Path, ending: str, value: float) -> None:
    path = write(tmp_path, ending, np.full(ROWS, value))
    np.testing.assert_array_equal(Recording.read(path).signal("position"), np.full(ROWS, value))


@pytest.mark.parametrize("ending", [".csv", ".h5"])
def test_a_twin_reads_what_lies_next_to_zero_as_zero(tmp_path: Path, ending: str) -> None:
    """Squares of such numbers vanish, and ratios of them are noise."""
    values = np.where(np.arange(ROWS) % 2, 5e-324, 1e-90)
    read = Recording.read(write(tmp_path, ending, values), AXIS).signal("position")
    np.testing.assert_array_equal(read, np.where(np.arange(ROWS) % 2, 0.0, 1e-90))


@pytest.mark.parametrize(("ending", "place"), [(".csv", "line 102"), (".h5", "row 101")])
@pytest.mark.parametrize("value", [1e101, -1.7e308])
def test_a_twin_refuses_what_no_sensor_measures(
    tmp_path: Path, ending: str, place: str, value: float
) -> None:
    values = np.where(np.arange(ROWS) == 100, value, 0.0)
    with pytest.raises(
        RecordingError, match=rf"column 'position', {place}: expected values below 1e\+100, got "
    ):
        Recording.read(write(tmp_path, ending, values), AXIS)


LIMITED = """
import sys
from gmfbo.recordings import Recording
recording = Recording.read(sys.argv[1])
print(len(recording), sorted(recording.signals), float(recording.signal("position")[-1]))
"""


def test_a_million_rows_are_read_in_bounded_memory(tmp_path: Path) -> None:
    """Numbers take 24 MB; a blank column and lines of remarks are no obstacle."""
    path = tmp_path / "long.csv"
    count = 1_000_000
    with path.open("w", encoding="utf-8") as file:
        file.write("# ctl.Kp = 90\ntime [s],position [rad],speed\n")
        for begin in range(0, count, 1000):
            rows = [f"{k},{k % 1000}.2500000000,\n" for k in range(begin, begin + 1000)]
            file.write("".join(rows))
    assert path.stat().st_size > LARGE_BYTES

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_DATA, (400 * 2**20, 400 * 2**20))

    ran = subprocess.run(
        [sys.executable, "-c", LIMITED, str(path)],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=limit,
    )
    assert ran.stdout.split() == ["1000000", "['position',", "'speed']", "999.25"], ran.stderr


def test_a_large_file_of_empty_lines_fills_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "lines.csv"
    path.write_bytes(b"\n" * (LARGE_BYTES + 1))
    with pytest.raises(RecordingError, match="must be a plain table of numbers"):
        Recording.read(path)


def test_a_large_file_with_text_among_its_numbers_names_the_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gmfbo.recordings.csv.table.LARGE_BYTES", 100)
    monkeypatch.setattr("gmfbo.recordings.csv.table.HEAD_BYTES", 200)
    path = write(tmp_path, ".csv", np.zeros(ROWS))
    np.testing.assert_array_equal(Recording.read(path).signal("position"), np.zeros(ROWS))
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[150] = "0.149,1.0,broken"
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(RecordingError, match=r"line 151, column 'position': .* got 'broken'"):
        Recording.read(path)
    monkeypatch.setattr("gmfbo.recordings.csv.table.LARGEST_LENIENT_BYTES", 100)
    with pytest.raises(RecordingError, match=r"must be a plain table of numbers .*export \.h5"):
        Recording.read(path)
