"""A plant run by a program, which takes gains and leaves a recording."""

from __future__ import annotations

import json
import re
import shutil
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from gmfbo.errors import NotTheGainsError, RecordingError
from gmfbo.objective.envelope import Envelope
from gmfbo.recordings.columns.signal import SignalReading
from gmfbo.recordings.recording import Recording, Trajectory, read_recording
from gmfbo.recordings.writing.writer import write_recording
from gmfbo.sources.plants.child_program import find_program, run_program
from gmfbo.sources.plants.failed_run import failed_run
from gmfbo.sources.plants.heartbeat import LOST_AFTER_S, beating
from gmfbo.sources.plants.run_guard import LATENCY

RECORDING = "recording"
NOT_THE_GAINS = 75
"""Exit status by which a program says that its run failed for another reason than its gains:
`EX_TEMPFAIL` of sysexits.h, to be tried again."""

_REQUEST, _REFERENCE, _HEARTBEAT = "request.json", "reference.csv", "heartbeat"


@dataclass(frozen=True)
class CommandPlant:
    """Runs a program once an experiment.

    The program is called as ``COMMAND --set NAME=VALUE ... --request FILE.json --reference
    FILE.csv --out FOLDER/recording.csv``. It writes a recording there, or with another readable
    ending, and ends with status 0. The request file holds the same arguments:
    ``{"gains": {NAME: VALUE}, "reference": FILE, "out": FILE}``, and for an abort in the program
    `safety`, `safe_gains` and `heartbeat`, which `RunGuard` reads. Status 75 says that the run
    failed for another reason than its gains, as a drive that is not ready does.

    Parameters
    ----------
    command : tuple of str
        Program and its first arguments.
    folder : Path
        Working folder of the program, where relative paths in the command begin.
    time_limit_s : float
        [s] A run that takes longer is ended, and counts as failed.
    retries : int
        How often a failed run is repeated before it counts.
    reading : SignalReading or None
        Tells which columns of the recording are signals, as a twin file does.
    envelope : Envelope
        Safety envelope, told to the program.
    safe_gains : mapping of str to float
        Gains of the last run that stayed inside it, told to the program.
    """

    command: tuple[str, ...]
    folder: Path
    time_limit_s: float = 600.0
    retries: int = 0
    reading: SignalReading | None = None
    envelope: Envelope = field(default_factory=Envelope)
    safe_gains: Mapping[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Program and script, without their folders."""
        return " ".join(Path(word).name for word in self.command[:2])

    @property
    def content_hash(self) -> str:
        """Empty, since the behaviour of a program cannot be hashed."""
        return ""

    def check(self) -> None:
        """Raise if the command's program does not exist.

        Raises
        ------
        StudyFileError
            There is no such program.
        """
        find_program(self.command[0], self.folder)

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        """Run the program; an error becomes the status and message of the result.

        Raises
        ------
        NotTheGainsError
            The program ended with status 75.
        """
        result = self._once(gains, reference)
        for _ in range(self.retries):
            if not _is_failed(result):
                break
            result = self._once(gains, reference)
        return result

    def close(self) -> None:
        """Do nothing."""

    def _once(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        folder = Path(tempfile.mkdtemp(prefix="gmfbo-run-"))
        began = time.perf_counter()
        try:
            result = self._run_in(folder, gains, reference, began)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        # A failed run's partial recording may have cost an hour.
        if not (_is_failed(result) and _left(folder)):
            shutil.rmtree(folder, ignore_errors=True)
        return result

    def _run_in(
        self, folder: Path, gains: Mapping[str, float], reference: Recording, began: float
    ) -> Recording:
        out = folder / f"{RECORDING}.csv"
        try:
            words = [find_program(self.command[0], self.folder), *self.command[1:]]
            words += self._arguments(folder, gains, reference, out)
            with beating(folder / _HEARTBEAT):
                ended = run_program(
                    words, folder=self.folder, logs=folder, time_limit_s=self.time_limit_s
                )
        except OSError as error:
            return failed_run(
                reference, f"{self.name}: cannot be started: {error.strerror}", name=self.name
            )
        seconds = time.perf_counter() - began
        left, fault = self._left_in(folder)
        said = f": {ended.last_line}" if ended.last_line else ""
        if ended.status is None:
            message = f"{self.name}: took longer than time_limit = {self.time_limit_s:g} s{said}"
        elif ended.status == NOT_THE_GAINS:
            raise NotTheGainsError(f"{self.name}: {ended.last_line or ended.reason}")
        elif ended.status != 0:
            message = f"{self.name}: {ended.reason}{said}"
        elif left is None:
            message = f"{self.name}: {fault}{said}"
        else:
            return left
        return failed_run(
            reference,
            message + _where(folder),
            name=self.name,
            status="timeout" if ended.status is None else "failed",
            seconds=seconds,
            left=left,
        )

    def _arguments(
        self, folder: Path, gains: Mapping[str, float], reference: Recording, out: Path
    ) -> Sequence[str]:
        request, followed = folder / _REQUEST, folder / _REFERENCE
        write_recording(reference, followed)
        condition = self.envelope.condition
        content = {
            "gains": dict(gains),
            "reference": str(followed),
            "out": str(out),
            "safety": {
                "ranges": {name: list(pair) for name, pair in self.envelope.ranges.items()},
                "expression": None if condition is None else condition.text,
            },
            "safe_gains": dict(self.safe_gains),
            "heartbeat": {"file": str(folder / _HEARTBEAT), "lost_after_s": LOST_AFTER_S},
        }
        request.write_text(json.dumps(content, indent=1), encoding="utf-8")
        settings = [
            word for name, value in gains.items() for word in ("--set", f"{name}={value!r}")
        ]
        files = ["--request", str(request), "--reference", str(followed), "--out", str(out)]
        return [*settings, *files]

    def _left_in(self, folder: Path) -> tuple[Recording | None, str]:
        """Recording that a program left, or the reason why there is none."""
        found = sorted(folder.glob(f"{RECORDING}.*"))
        if len(found) != 1:
            names = ", ".join(path.name for path in found)
            return None, f"expected one recording, --out FILE, got {names or 'none'}"
        try:
            return _with_latency(read_recording(found[0], self.reading), found[0]), ""
        except RecordingError as error:
            return None, str(error)


def _with_latency(run: Recording, path: Path) -> Recording:
    """The run with the latency of its abort; by a twin file only its parameters are read."""
    if path.suffix != ".csv":
        return run
    said = re.search(rf"^# *{LATENCY} *= *(\S+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    try:
        latency = {} if said is None else {LATENCY: float(said[1])}
    except ValueError:
        return run
    return replace(run, parameters={**run.parameters, **latency})


def _is_failed(result: Recording) -> bool:
    return isinstance(result, Trajectory) and result.status in ("failed", "timeout")


def _where(folder: Path) -> str:
    return f"; what it left is in {folder}" if _left(folder) else ""


def _left(folder: Path) -> list[Path]:
    ours = {_REQUEST, _REFERENCE, _HEARTBEAT, "stdout.txt", "stderr.txt"}
    return [path for path in folder.iterdir() if path.name not in ours]
