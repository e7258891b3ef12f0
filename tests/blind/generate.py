"""Writes the cases of a benchmark, their answers apart, and the hash of every answer."""

from __future__ import annotations

import argparse
import hashlib
import json
import multiprocessing
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from tests.blind.cases import make_case
from tests.blind.plan import SHARES, Plan, make_plan

HASHES = "answers.sha256"

CASES = sum(SHARES.values())
"""Of the whole benchmark."""


def generate(
    cases: int, seed: int, out: Path, jobs: int = 1, start: int = 0, count: int | None = None
) -> list[Path]:
    """Write what is missing of a benchmark; answers that are there are kept.

    Parameters
    ----------
    cases, seed : int
        Size and seed of the benchmark.
    out : Path
        Its folder.
    jobs : int
        Processes.
    start, count : int
        Only so many cases from this one on; all that follow if None.

    Returns
    -------
    list of Path
        The folders of the cases.

    Raises
    ------
    ValueError
        The folder holds another benchmark, or an answer is not the one that was hashed.
    """
    chosen = range(start, cases if count is None else min(cases, start + count))
    open_folder(out, "benchmark", {"cases": cases, "seed": seed})
    plans = make_plan(cases, seed)
    tasks = [
        (plans[index], seed, index, out) for index in chosen if not answer_path(out, index).exists()
    ]
    if jobs > 1:
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(jobs, mp_context=context) as pool:
            for line in pool.map(_write_case, *zip(*tasks, strict=True)) if tasks else ():
                print(line, flush=True)
                write_hashes(out)
    else:
        for task in tasks:
            print(_write_case(*task), flush=True)
            write_hashes(out)
    write_hashes(out)
    return [case_folder(out, index) for index in chosen]


def open_folder(out: Path, what: str, made_by: Mapping[str, object]) -> None:
    """Begin a folder of cases, or go on with one.

    Parameters
    ----------
    out : Path
        The folder.
    what : str
        What it holds, for the message.
    made_by : mapping of str to object
        Decides its cases: size and seed.

    Raises
    ------
    ValueError
        The folder was made by something else, or an answer is not the one that was hashed.
    """
    stamp = json.dumps(dict(made_by))
    stamped = out / "benchmark.json"
    if stamped.exists() and stamped.read_text(encoding="utf-8") != stamp:
        raise ValueError(f"{out} holds the {what} {stamped.read_text(encoding='utf-8')}")
    (out / "answers").mkdir(parents=True, exist_ok=True)
    stamped.write_text(stamp, encoding="utf-8")
    if (out / HASHES).exists():
        check_hashes(out)


def case_folder(out: Path, index: int) -> Path:
    """Folder of a case: all that the diagnosis sees."""
    return out / "cases" / f"{index:03d}"


def answer_path(out: Path, index: int) -> Path:
    """Answer of a case, outside its folder."""
    return out / "answers" / f"{index:03d}.json"


def _write_case(plan: Plan, seed: int, index: int, out: Path) -> str:
    answer = make_case(plan, seed, index, case_folder(out, index))
    path = answer_path(out, index)
    partial = path.with_suffix(".partial")
    partial.write_text(answer.text(), encoding="utf-8")
    partial.replace(path)
    return f"{index:03d} written"


def write_hashes(out: Path) -> None:
    """Write the hash of every answer that is there."""
    lines = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}"
        for path in sorted((out / "answers").glob("*.json"))
    ]
    (out / HASHES).write_text("\n".join([*lines, ""]), encoding="utf-8")


def check_hashes(out: Path) -> list[str]:
    """Compare every answer with the hash that was written before the run; their cases.

    Raises
    ------
    ValueError
        An answer has changed, came or went.
    """
    cases = []
    for line in (out / HASHES).read_text(encoding="utf-8").split("\n")[:-1]:
        expected, name = line.split()
        if hashlib.sha256((out / "answers" / name).read_bytes()).hexdigest() != expected:
            raise ValueError(f"{name} is not the answer that was hashed before the run")
        cases.append(Path(name).stem)
    return cases


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.generate."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").strip())
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--start", type=int, default=0, help="first case of this chunk")
    parser.add_argument("--count", type=int, help="cases of this chunk; all that follow without it")
    given = parser.parse_args(arguments)
    folders = generate(given.cases, given.seed, given.out, given.jobs, given.start, given.count)
    print(f"{len(folders)} cases in {given.out / 'cases'}")


if __name__ == "__main__":
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    main()
