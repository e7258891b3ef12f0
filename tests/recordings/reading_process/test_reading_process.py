"""A file that crashes, hangs or fills its reader costs one line, not the program."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording
from gmfbo.recordings.columns.columns import RecordedColumns
from gmfbo.recordings.formats.hdf5_file import read_hdf5
from gmfbo.recordings.reading_process import reading_process
from gmfbo.recordings.reading_process.reading_process import Reader, read_apart, try_apart
from tests.recordings.reading_process.bad_readers import (
    chatter,
    crash,
    fill,
    hang,
    leave,
    loop,
    loop_too,
    raise_,
)


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A plain HDF5 file; the process that reads it finds the bad readers of the tests."""
    root = str(Path(__file__).resolve().parents[3])
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([root, os.environ.get("PYTHONPATH", "")]))
    reading_process.end_reading()
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as content:
        content["time"] = np.arange(4.0)
        content["a"] = np.array([1.0, np.nan, np.inf, 5e-324])
    return path


def pid_of_reader(file: Path) -> int:
    """Number of the reading process, which has read a file by then."""
    Recording.read(file)
    return reading_process._running[0].pid


def test_numbers_come_back_bit_by_bit_and_the_process_is_kept(file: Path) -> None:
    recording = Recording.read(file)
    np.testing.assert_array_equal(recording.signal("a"), [1.0, np.nan, np.inf, 5e-324])
    assert pid_of_reader(file) == pid_of_reader(file)


@pytest.mark.parametrize(
    ("reader", "match"),
    [
        (crash, r"run\.h5: the library that reads such files crashed .SIGSEGV.; the file is dam"),
        (leave, r"run\.h5: the library that reads such files crashed .exit status 3.;"),
        (fill, r"run\.h5: its contents need far more memory than a file of its size should"),
        (raise_, r"run\.h5: damaged, or not of the kind .* .ZeroDivisionError: no such thing."),
    ],
)
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits and signals of Linux")
def test_a_bad_file_is_one_line_and_the_next_file_is_read(
    file: Path, reader: Reader, match: str
) -> None:
    with pytest.raises(RecordingError, match=match) as error:
        read_apart(file, reader)
    assert "\n" not in str(error.value)
    assert len(Recording.read(file)) == 4


def test_a_reader_that_hangs_is_ended_at_the_limit(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pid = pid_of_reader(file)
    monkeypatch.setattr(reading_process, "TIME_LIMIT_S", 0.3)
    began = time.monotonic()
    with pytest.raises(RecordingError, match="did not end within 0 s; the file is damaged"):
        read_apart(file, hang)
    assert time.monotonic() - began < 5.0
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no process's computing")
def test_a_reader_that_loops_is_ended_by_what_it_computed(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However busy the machine is; what waits and does not compute has the limit of time."""
    monkeypatch.setattr(reading_process, "PROCESSOR_LIMIT_S", 1.0)
    monkeypatch.setattr(reading_process, "TIME_LIMIT_S", 300.0)
    for written in (1, 2):  # the limit counts anew for each file
        os.utime(file, (written, written))
        with pytest.raises(RecordingError, match="did not end within 1 s of computing; the file"):
            read_apart(file, loop)
        assert len(Recording.read(file)) == 4
    monkeypatch.setattr(reading_process, "TIME_LIMIT_S", 2.0)
    with pytest.raises(RecordingError, match="did not end within 2 s; the file"):
        read_apart(file, hang)  # control


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no process's computing")
def test_a_file_in_which_a_reader_looped_is_not_waited_for_again(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another way to read it, a repair's, still gets a short try."""
    monkeypatch.setattr(reading_process, "PROCESSOR_LIMIT_S", 1.0)
    monkeypatch.setattr(reading_process, "TIME_LIMIT_S", 300.0)
    with pytest.raises(RecordingError, match="within 1 s of computing"):
        read_apart(file, loop)
    pid = pid_of_reader(file)
    with pytest.raises(RecordingError, match="within 1 s of computing"):
        read_apart(file, loop)
    assert pid_of_reader(file) == pid  # nothing was ended
    with pytest.raises(RecordingError, match="within 2 s of computing"):
        try_apart(file, loop_too)


def test_what_a_library_prints_does_not_reach_the_answer(file: Path) -> None:
    try_apart(file, chatter)
    assert len(Recording.read(file)) == 4


def test_files_read_by_several_threads_wait_for_each_other(file: Path) -> None:
    lengths = []
    threads = [
        threading.Thread(target=lambda: lengths.append(len(Recording.read(file)))) for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert lengths == [4] * 8


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks at /proc")
def test_the_reading_process_ends_with_a_killed_parent(file: Path) -> None:
    program = (
        "import sys, time\nfrom gmfbo.recordings import Recording\n"
        "from gmfbo.recordings.reading_process import reading_process\n"
        f"Recording.read({str(file)!r})\n"
        "print(reading_process._running[0].pid, flush=True)\ntime.sleep(30)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True
    ) as parent:
        assert parent.stdout is not None
        pid = int(parent.stdout.readline())
        parent.send_signal(signal.SIGKILL)
    for _ in range(100):
        if not Path(f"/proc/{pid}").exists() or "Z" in _state(pid):
            return
        time.sleep(0.05)
    pytest.fail("the reading process outlived its parent")


def _state(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return "Z"


def test_a_dataset_that_claims_terabytes_fills_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "bomb.h5"
    with h5py.File(path, "w") as content:
        content.create_dataset("time", shape=(2**40,), dtype="f8", chunks=(1024,))
    assert path.stat().st_size < 10_000
    with pytest.raises(RecordingError, match=r"bomb\.h5: its contents need far more memory"):
        Recording.read(path)


def test_columns_without_rows_come_back(tmp_path: Path) -> None:
    path = tmp_path / "none.h5"
    with h5py.File(path, "w") as content:
        content["time"] = np.empty(0)
        content["a"] = np.empty(0)
    read = read_apart(path, read_hdf5)
    assert isinstance(read, RecordedColumns)
    assert [column.values.size for column in read.columns] == [0, 0]
