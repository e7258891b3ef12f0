"""Run another program within a time limit, and end it with all processes that it started."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from gmfbo.errors import StudyFileError
from gmfbo.interrupt import signal_name

GRACE_S = 5.0
"""[s] Time for a program to bring its axis to rest when asked to end; then it is killed."""

_TAIL_BYTES = 4096


@dataclass(frozen=True)
class Ended:
    """End of a program.

    Attributes
    ----------
    status : int or None
        Exit status, negative where a signal ended it; None where it exceeded the time limit.
    last_line : str
        Last line of its standard error, or where that is empty, of its standard output.
    """

    status: int | None
    last_line: str

    @property
    def reason(self) -> str:
        """Exit status in words."""
        assert self.status is not None
        if self.status >= 0:
            return f"exit status {self.status}"
        return f"ended by {signal_name(self.status)}"


def find_program(word: str, folder: Path) -> str:
    """Find the program that the first word of a command names.

    A word with a path is relative to `folder`, any other is searched on PATH. Where PATH has no
    `python`, the interpreter that runs gmfbo is used.

    Raises
    ------
    StudyFileError
        There is no such program.
    """
    has_path = Path(word).name != word
    # shutil.which adds .exe, .bat and .cmd on Windows, also to a full path.
    found = shutil.which(str(folder.absolute() / word) if has_path else word)
    if found is None and word in ("python", "python3"):
        found = sys.executable
    if found is None:
        where = f"in {folder}" if has_path else "on PATH"
        raise StudyFileError(
            f"[is1] command: no program '{word}' {where}; give its path, and make it executable"
        )
    return found


def run_program(
    command: Sequence[str],
    *,
    folder: Path,
    logs: Path,
    time_limit_s: float,
    grace_s: float = GRACE_S,
) -> Ended:
    """Run a program without a shell and wait for its end.

    Parameters
    ----------
    command : sequence of str
        Program and arguments; each reaches the program as it is, on Windows too.
    folder : Path
        Working folder of the program.
    logs : Path
        Folder where `stdout.txt` and `stderr.txt` are written.
    time_limit_s : float
        [s] After it the program is asked to end, and after `grace_s` more it is killed.
    grace_s : float
        [s] Time between both; also when gmfbo is interrupted.

    Raises
    ------
    OSError
        The program cannot be started.
    """
    out, err = logs / "stdout.txt", logs / "stderr.txt"
    with out.open("wb") as stdout, err.open("wb") as stderr:
        process = _start(command, folder, stdout, stderr)
        try:
            status: int | None = process.wait(timeout=time_limit_s)
        except subprocess.TimeoutExpired:
            status = None
        finally:
            # On Ctrl-C as well: an axis must not go on moving unwatched.
            _end(process, grace_s)
    return Ended(status, _last_line(err) or _last_line(out))


def _last_line(path: Path) -> str:
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - _TAIL_BYTES, 0))
        lines = file.read().decode("utf-8", "replace").split("\n")
    said = [" ".join(line.split()) for line in lines if line.strip()]
    return said[-1] if said else ""


if sys.platform == "win32":

    def _start(
        command: Sequence[str], folder: Path, stdout: IO[bytes], stderr: IO[bytes]
    ) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            list(command),
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=stdout,
            stderr=stderr,
            creationflags=subprocess.CREATE_NEW_PROCESS_GROUP,
        )

    def _end(process: subprocess.Popen[bytes], grace_s: float) -> None:
        if process.poll() is not None:
            return
        with contextlib.suppress(OSError):
            process.send_signal(signal.CTRL_BREAK_EVENT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(grace_s)
        # Windows has no process group to kill; taskkill ends the whole tree.
        subprocess.run(
            ["taskkill", "/F", "/T", "/PID", str(process.pid)], capture_output=True, check=False
        )
        process.kill()
        process.wait()

else:

    def _start(
        command: Sequence[str], folder: Path, stdout: IO[bytes], stderr: IO[bytes]
    ) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            list(command),
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=stdout,
            stderr=stderr,
            # A group of its own, so that its children can be ended with it.
            start_new_session=True,
        )

    def _end(process: subprocess.Popen[bytes], grace_s: float) -> None:
        try:
            if process.poll() is None:
                _signal_group(process, signal.SIGTERM)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(grace_s)
        finally:  # a second Ctrl-C ends the grace time
            # Children left behind by the program would block the axis for the next run.
            _signal_group(process, signal.SIGKILL)
            process.wait()

    def _signal_group(process: subprocess.Popen[bytes], number: int) -> None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, number)
