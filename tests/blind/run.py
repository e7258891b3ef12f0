"""Runs `gmfbo diagnose` on every case of a benchmark, each in a process of its own."""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from tests.blind.generate import check_hashes

TIME_LIMIT = 300.0
"""[s] A case that takes longer has failed."""


def run_all(
    out: Path,
    jobs: int,
    only: Sequence[str] = (),
    limit: float = TIME_LIMIT,
    keep: bool = False,
) -> None:
    """Run the cases that have no outcome yet.

    Parameters
    ----------
    out : Path
        Folder of the benchmark.
    jobs : int
        Cases at a time.
    only : sequence of str
        Numbers of cases; they are run again. All that are missing if empty.
    limit : float
        [s] Wall clock of a case.
    keep : bool
        Keep report and augmented FMU of each case, a megabyte.

    Raises
    ------
    ValueError
        An answer is not the one that was hashed.
    """
    hashed = check_hashes(out)
    chosen = [
        out / "cases" / case
        for case in hashed
        if (case in only if only else not outcome_path(out, case).exists())
    ]
    with ThreadPoolExecutor(jobs) as pool:
        futures = [pool.submit(run_case, folder, out, limit, keep) for folder in chosen]
        for done, future in enumerate(as_completed(futures), 1):
            print(f"{done} of {len(chosen)}: {future.result()}", flush=True)


def run_case(folder: Path, out: Path, limit: float, keep: bool = False) -> str:
    """Diagnose one case and keep what it left; answers a line for the log.

    It simulates in one process, as two cases run at a time; what `out/arguments/CASE.json` lists
    is added to the command.
    """
    results = out / "results" / folder.name
    results.mkdir(parents=True, exist_ok=True)
    (results / "diagnosis.json").unlink(missing_ok=True)
    recordings = sorted(str(path.resolve()) for path in folder.glob("rec*.csv"))
    command = [sys.executable, "-m", "gmfbo", "diagnose", str((folder / "twin.toml").resolve())]
    command += [*recordings, "--out", str(results.resolve()), "--seed", "0", "--jobs", "1"]
    extra = out / "arguments" / f"{folder.name}.json"
    command += json.loads(extra.read_text(encoding="utf-8")) if extra.exists() else []
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    began, note = time.monotonic(), ""
    with (
        (results / "stdout.txt").open("wb") as stdout,
        (results / "stderr.txt").open("wb") as stderr,
    ):
        process = subprocess.Popen(
            command,
            stdout=stdout,
            stderr=stderr,
            stdin=subprocess.DEVNULL,
            env={**os.environ, **threads},
            start_new_session=True,
        )
        try:
            status = process.wait(limit)
        except subprocess.TimeoutExpired:
            _end(process)
            status, note = -1, f"more than {limit:g} s"
    seconds = time.monotonic() - began
    if status > 0 or (status < 0 and not note):
        lines = (results / "stderr.txt").read_text(errors="replace").strip().splitlines()
        note = f"status {status}: {lines[-1] if lines else ''}"
    if not keep:
        for left in ("augmented.fmu", "augmented.toml", "report.html"):
            (results / left).unlink(missing_ok=True)
    outcome = {"status": status, "seconds": round(seconds, 2), "note": note}
    outcome_path(out, folder.name).write_text(json.dumps(outcome), encoding="utf-8")
    return f"{folder.name} {seconds:6.1f} s {note or 'done'}"


def outcome_path(out: Path, case: str) -> Path:
    """How the command ended on a case; there once it has."""
    return out / "results" / case / "outcome.json"


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a case with all that it started."""
    if hasattr(os, "killpg"):
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    process.wait()


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.run."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").strip())
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", nargs="+", default=[], metavar="CASE")
    parser.add_argument("--limit", type=float, default=TIME_LIMIT, help="[s] for each case")
    parser.add_argument("--keep", action="store_true", help="keep reports and augmented FMUs")
    given = parser.parse_args(arguments)
    run_all(given.out, given.jobs, given.only, given.limit, given.keep)


if __name__ == "__main__":
    main()
