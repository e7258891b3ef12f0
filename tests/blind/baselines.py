"""Runs the baselines on cases that have been diagnosed; what is there already is kept.

    python -m tests.blind.baselines --out FOLDER [--brute 48] [--only 003 007]

Sparse regression and the Gaussian process run on all cases, brute force on the first `--brute`
in the benchmark's own (random) order. Nominal twin and parameters alone come from the diagnosis.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from subprocess import DEVNULL, run
from sys import executable
from typing import Any

from tests.blind.generate import check_hashes

BRUTE = 48
_TIME_LIMIT = 900.0


def baseline_path(out: Path, case: str) -> Path:
    """Results of the baselines on a case."""
    return out / "results" / case / "baselines.json"


def run_baselines(folder: Path, diagnosis: dict[str, Any], brute: bool) -> dict[str, Any]:
    """All baselines on one case.

    Parameters
    ----------
    folder : Path
        Of the case.
    diagnosis : dict
        Content of its diagnosis.json, for the recording that was held out.
    brute : bool
        Fit every effect too.
    """
    from tests.blind.refits import Refits
    from tests.blind.sparse_regression import sparse_names

    held = ((diagnosis.get("fit") or {}).get("held_out") or ["rec1.csv"])[0]
    began = time.monotonic()
    results: dict[str, Any] = {"sparse": {"names": list(sparse_names(folder))}}
    results["sparse"]["seconds"] = time.monotonic() - began
    began = time.monotonic()
    with Refits(folder, Path(held).name) as refits:
        results["gp"] = {"ratio": refits.gp_ratio(), "simulations": refits.simulations}
        results["gp"]["seconds"] = time.monotonic() - began
        if brute:
            began = time.monotonic()
            results["brute"] = {"names": list(refits.brute_force())}
            results["brute"]["simulations"] = refits.simulations
            results["brute"]["seconds"] = time.monotonic() - began
    return results


def _one(out: Path, case: str, brute: bool) -> str:
    """A case in a process of its own: a twin that fails takes nothing else along."""
    command = [executable, "-m", "tests.blind.baselines", "--out", str(out), "--case", case]
    command += ["--brute", "1" if brute else "0"]
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    done = run(
        command,
        stdin=DEVNULL,
        capture_output=True,
        text=True,
        timeout=_TIME_LIMIT,
        env={**os.environ, **threads},
    )
    error = done.stderr.strip().splitlines()
    return f"{case} {'done' if done.returncode == 0 else (error or ['failed'])[-1]}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.baselines."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--brute", type=int, default=BRUTE, help="cases for brute force")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", nargs="+", default=[], metavar="CASE")
    parser.add_argument("--case", help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    if given.case:
        text = (given.out / "results" / given.case / "diagnosis.json").read_text(encoding="utf-8")
        folder = given.out / "cases" / given.case
        results = run_baselines(folder, json.loads(text), given.brute > 0)
        path = baseline_path(given.out, given.case)
        path.write_text(json.dumps(results), encoding="utf-8")
        return
    ended = [
        (case, k < given.brute)
        for k, case in enumerate(check_hashes(given.out))
        if (given.out / "results" / case / "diagnosis.json").exists()
        and (case in given.only if given.only else not baseline_path(given.out, case).exists())
    ]
    with ThreadPoolExecutor(given.jobs) as pool:
        for line in pool.map(lambda each: _one(given.out, *each), ended):
            print(line, flush=True)


if __name__ == "__main__":
    main()
