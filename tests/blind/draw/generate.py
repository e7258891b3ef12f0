"""Writes the cases of a draw, their answers apart, and the hash of every answer."""

from __future__ import annotations

import argparse
import multiprocessing
import os
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from tests.blind.draw.cases import make_drawn
from tests.blind.draw.mujoco_axis import WHY_NOT, has_mujoco
from tests.blind.draw.plan import (
    DEVELOPMENT,
    DEVELOPMENT_SEED,
    REGISTERED,
    DrawnCase,
    draw_plan,
)
from tests.blind.generate import answer_path, case_folder, open_folder, write_hashes


def generate_draw(
    counts: Mapping[str, int],
    seed: int,
    out: Path,
    jobs: int = 1,
    chosen: Sequence[int] | None = None,
) -> list[Path]:
    """Write what is missing of a draw; answers that are there are kept.

    Parameters
    ----------
    counts : mapping of str to int
        Cases of each stratum.
    seed : int
        Of the draw.
    out : Path
        Its folder.
    jobs : int
        Processes.
    chosen : sequence of int, optional
        Only these cases.

    Returns
    -------
    list of Path
        The folders of the cases.

    Raises
    ------
    ValueError
        The folder holds another draw, or an answer is not the one that was hashed.
    RuntimeError
        MuJoCo, or the compiler, is not installed.
    """
    cases = draw_plan(counts, seed)
    wanted = range(len(cases)) if chosen is None else chosen
    open_folder(out, "draw", {"counts": dict(counts), "seed": seed})
    tasks = [
        (cases[index], seed, index, out) for index in wanted if not answer_path(out, index).exists()
    ]
    if not has_mujoco() and any(case.family == "simulator" for case, *_ in tasks):
        raise RuntimeError(WHY_NOT)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(max(1, jobs), mp_context=context) as pool:
        for line in pool.map(_write_case, tasks):
            print(line, flush=True)
            write_hashes(out)
    write_hashes(out)
    return [case_folder(out, index) for index in wanted]


def _write_case(task: tuple[DrawnCase, int, int, Path]) -> str:
    case, seed, index, out = task
    began = time.monotonic()
    answer = make_drawn(case, seed, index, case_folder(out, index), out / "models")
    path = answer_path(out, index)
    partial = path.with_suffix(".partial")
    partial.write_text(answer.text(), encoding="utf-8")
    partial.replace(path)
    what = f"{case.stratum} {case.family} {case.variant}".strip()
    return f"{index:03d} {what}, {time.monotonic() - began:.1f} s"


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line: python -m tests.blind.draw.generate."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").strip())
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seed", type=int, help=f"development: {DEVELOPMENT_SEED}")
    parser.add_argument("--registered", action="store_true", help="700 cases; needs --seed")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", type=int, nargs="+", metavar="CASE")
    parser.add_argument("--stratum", help="only cases of this one")
    given = parser.parse_args(arguments)
    if given.registered and given.seed is None:
        parser.error("expected --seed beside --registered, got none: it is drawn from a commit")
    counts = REGISTERED if given.registered else DEVELOPMENT
    seed = DEVELOPMENT_SEED if given.seed is None else given.seed
    chosen = given.only
    if given.stratum:
        plan = draw_plan(counts, seed)
        chosen = [k for k in chosen or range(len(plan)) if plan[k].stratum == given.stratum]
    folders = generate_draw(counts, seed, given.out, given.jobs, chosen)
    print(f"{len(folders)} cases in {given.out / 'cases'}")


if __name__ == "__main__":
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    main()
