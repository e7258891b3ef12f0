"""Diagnoses the cases of a draw; a line a case, with what was said and what was hidden.

    python -m tests.blind.draw.run --out FOLDER --to OUTCOMES.jsonl [--jobs 2] [--limit 300]
        [--strata null owed] [--only 003 007] [--retry] [--engine gmfbo:diagnose]

Lines are flushed as cases end, and a case that has a line is not run again: stop it and call it
again as often as you like. The engine is a function (twin file, recordings, jobs=1) that gives a
`Diagnosis`.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from tests.blind.draw.judging import judge
from tests.blind.draw.outcomes import drop_cut_line, read_outcomes
from tests.blind.generate import check_hashes

TIME_LIMIT = 300.0
"""[s] A case that takes longer has failed."""

MOST_JOBS = 2


def run_draw(
    out: Path,
    to: Path,
    *,
    jobs: int = 1,
    limit: float = TIME_LIMIT,
    strata: Sequence[str] = (),
    only: Sequence[str] = (),
    engine: str = "gmfbo:diagnose",
    retry: bool = False,
) -> int:
    """Run the cases that have no line yet; how many.

    Parameters
    ----------
    out : Path
        Folder of the draw.
    to : Path
        File of outcomes; lines are added at its end.
    jobs : int
        Cases at a time, two at most.
    limit : float
        [s] Wall clock of a case.
    strata : sequence of str
        Of which cases are taken, in this order; all if empty.
    only : sequence of str
        Numbers of cases; all if empty.
    engine : str
        MODULE:FUNCTION.
    retry : bool
        Run those again that ended without a diagnosis, as with a longer limit.

    Raises
    ------
    ValueError
        An answer is not the one that was hashed, or `jobs` is more than two.
    """
    if not 1 <= jobs <= MOST_JOBS:
        raise ValueError(
            f"expected 1 or 2 jobs, got {jobs}: more of them change each other's times"
        )
    drop_cut_line(to)
    lines = read_outcomes(to)
    done = {line["case"] for line in lines if line["diagnosis"] is not None or not retry}
    cases = [case for case in check_hashes(out) if case not in done and (not only or case in only)]
    answers = {case: _answer(out, case) for case in cases}
    if strata:
        cases = [c for s in strata for c in cases if answers[c]["details"]["stratum"] == s]
    to.parent.mkdir(parents=True, exist_ok=True)
    lock, running = threading.Lock(), Running()
    with to.open("a", encoding="utf-8") as file, ThreadPoolExecutor(jobs) as pool:

        def one(case: str) -> str:
            line = run_one(out / "cases" / case, answers[case], limit, engine, running)
            with lock:
                file.write(json.dumps(line) + "\n")
                file.flush()
            return f"{case} {line['seconds']:6.1f} s {judge(line).told()}"

        futures = [pool.submit(one, case) for case in cases]
        try:
            for count, future in enumerate(as_completed(futures), 1):
                print(f"{count} of {len(cases)}: {future.result()}", flush=True)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            running.end_all()
            raise
    return len(cases)


class Running:
    """The cases that are being diagnosed, so that none outlives a runner that is stopped."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._processes: set[subprocess.Popen[str]] = set()
        self._is_stopped = False

    def start(self, command: Sequence[str]) -> subprocess.Popen[str]:
        """Start a process in a session of its own.

        Raises
        ------
        RuntimeError
            The runner has been stopped.
        """
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        with self._lock:
            self.check()
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                env=environment,
                start_new_session=True,
            )
            self._processes.add(process)
        return process

    def check(self) -> None:
        """Raise where the runner has been stopped: what such a case came to is no outcome."""
        if self._is_stopped:
            raise RuntimeError("the runner was stopped")

    def end_all(self) -> None:
        """End all that are under way, and let none begin."""
        with self._lock:
            self._is_stopped = True
            for process in self._processes:
                if process.poll() is None:
                    _kill(process)

    def ended(self, process: subprocess.Popen[str]) -> None:
        """Forget a process that has ended."""
        with self._lock:
            self._processes.discard(process)


def run_one(
    folder: Path, answer: dict[str, Any], limit: float, engine: str, running: Running
) -> dict[str, Any]:
    """Diagnose one case; its line.

    Parameters
    ----------
    folder : Path
        Of the case.
    answer : dict
        What it hides: copied into the line, never shown to the process that diagnoses.
    limit : float
        [s] Wall clock.
    engine : str
        MODULE:FUNCTION.
    running : Running
        Starts the process.

    Raises
    ------
    RuntimeError
        The runner was stopped meanwhile.
    """
    command = [sys.executable, "-m", "tests.blind.draw.one", str(folder), "--engine", engine]
    began, note, said = time.monotonic(), "", {"diagnosis": None, "cpu_seconds": None}
    process = running.start(command)
    try:
        printed, complaints = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        _kill(process)
        process.communicate()
        printed, complaints, note = "", "", f"more than {limit:g} s"
    running.ended(process)
    running.check()
    if process.returncode == 0:
        said = json.loads(printed.strip().splitlines()[-1])
    elif not note:
        last = complaints.strip().splitlines()[-1:] or [""]
        note = f"status {process.returncode}: {last[0]}"
    seconds = round(time.monotonic() - began, 2)
    return {
        "case": folder.name,
        "seconds": seconds,
        "note": note,
        "answer": answer,
        **said,
    }


def _kill(process: subprocess.Popen[str]) -> None:
    """End a case with all that it started."""
    if hasattr(os, "killpg"):
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()


def _answer(out: Path, case: str) -> dict[str, Any]:
    content = json.loads((out / "answers" / f"{case}.json").read_text(encoding="utf-8"))
    return dict(content)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.draw.run."""
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").strip(), formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--to", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit", type=float, default=TIME_LIMIT, help="[s] for each case")
    parser.add_argument("--strata", nargs="+", default=[])
    parser.add_argument("--only", nargs="+", default=[], metavar="CASE")
    parser.add_argument("--retry", action="store_true", help="those without a diagnosis again")
    parser.add_argument("--engine", default="gmfbo:diagnose", metavar="MODULE:FUNCTION")
    given = parser.parse_args(arguments)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    run_draw(
        given.out,
        given.to,
        jobs=given.jobs,
        limit=given.limit,
        strata=given.strata,
        only=given.only,
        engine=given.engine,
        retry=given.retry,
    )


if __name__ == "__main__":
    main()
