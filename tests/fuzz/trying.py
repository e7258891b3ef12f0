"""One file given to its reader: what came out, how long it took, how much memory."""

from __future__ import annotations

import contextlib
import os
import resource
import time
from dataclasses import dataclass, field
from pathlib import Path

from gmfbo.errors import GmfboError
from gmfbo.recordings.reading_process import reading_process
from tests.fuzz.targets import Target, assert_one_line


@dataclass
class Tally:
    """What came out of many files.

    Attributes
    ----------
    tried, read : int
        Files, and of them those that were read without complaint.
    refused : dict of str to int
        Refusals by the class of our error.
    ended_reader : int
        Files that crashed the reading process, hung it, or met its limit of memory.
    faults : list of str
        What must not happen: another error, too long, too much memory.
    seconds, megabytes : float
        Worst of one file: processor time of this process and of the one that reads, and growth
        of its memory [1e6 bytes].
    """

    tried: int = 0
    read: int = 0
    refused: dict[str, int] = field(default_factory=dict)
    ended_reader: int = 0
    faults: list[str] = field(default_factory=list)
    seconds: float = 0.0
    megabytes: float = 0.0


_ENDED = ("the library that reads such files", "need far more memory")


def try_file(target: Target, content: bytes, folder: Path, tally: Tally) -> list[str]:
    """Let the target's reader have a file; returns what was wrong with how it took it.

    Parameters
    ----------
    target : Target
        Reader and limits.
    content : bytes
        Of the file.
    folder : Path
        Empty; the file is written into it and removed.
    tally : Tally
        Counts on.
    """
    path = folder / target.name
    path.write_bytes(content)
    faults: list[str] = []
    before = _forget_peaks(target)
    began = _computed(target)
    try:
        target.read(path)
        tally.read += 1
    except GmfboError as refused:
        kind = type(refused).__name__
        tally.refused[kind] = tally.refused.get(kind, 0) + 1
        tally.ended_reader += any(words in str(refused) for words in _ENDED)
        try:
            assert_one_line(refused)
        except AssertionError as unclear:
            faults.append(str(unclear))
    except Exception as error:
        faults.append(f"{type(error).__name__}: {' '.join(str(error).split())[:200]}")
    seconds, megabytes = _computed(target) - began, _grown(target, before)
    if seconds > target.seconds:
        faults.append(f"took {seconds:.1f} s, at most {target.seconds:g} s")
    if megabytes > target.megabytes:
        faults.append(f"took {megabytes:.0f} MB, at most {target.megabytes:g} MB")
    tally.tried += 1
    tally.seconds, tally.megabytes = max(tally.seconds, seconds), max(tally.megabytes, megabytes)
    tally.faults += faults
    path.unlink(missing_ok=True)
    return faults


def _pids(target: Target) -> list[str]:
    if not target.apart:
        return ["self"]
    return ["self", *(str(process.pid) for process in reading_process._running if process.usable)]


def _computed(target: Target) -> float:
    """[s] Processor time of this process and of the reading processes, ended ones too.

    Other programs of the machine have no part in it, as they have in the time that passes.
    """
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (
        time.process_time()
        + (ended.ru_utime + ended.ru_stime)
        + sum(_processor_s(pid) for pid in _pids(target) if pid != "self")
    )


def _processor_s(pid: str) -> float:
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    except OSError:
        return 0.0
    user, system = text.rpartition(")")[2].split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def _forget_peaks(target: Target) -> dict[str, float]:
    """Let the kernel measure the peak anew; memory in use now, by process."""
    for pid in _pids(target):
        with contextlib.suppress(OSError):
            Path(f"/proc/{pid}/clear_refs").write_text("5", encoding="ascii")
    return {pid: _status(pid, "VmRSS") for pid in _pids(target)}


def _grown(target: Target, before: dict[str, float]) -> float:
    """[MB] Largest growth of this process or the one that reads; 0 where it is not told."""
    peaks = [_status(pid, "VmHWM") - before.get(pid, 0.0) for pid in _pids(target)]
    return max([0.0, *peaks])


def _status(pid: str, key: str) -> float:
    try:
        text = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    except OSError:
        return 0.0
    for line in text.splitlines():
        if line.startswith(f"{key}:"):
            return float(line.split()[1]) * 1024 / 1e6
    return 0.0
