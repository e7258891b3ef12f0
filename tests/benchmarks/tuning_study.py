"""Methods on the drive: real runs until the optimum, on the same seeds and initial data.

IS1 is the drive twin; IS2 is the same drive with noise in its flux map, drawn anew for each
seed. n* is the number of real runs, initial ones counted, until the best observed one has a
noise-free cost <= g_min + 0.02 (g_median - g_min) over a 41 x 41 grid of IS1. Each method runs
until 22 real runs or 100 queries after the initial data; a run that never arrives has n* = 23.

    python tests/benchmarks/tuning_study.py --seeds 10

Finished (method, seed) pairs are kept in the work folder and not run again; the table goes to
`results/tuning_study.txt`.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo import FmuTwin, Study, Tuner, step_reference
from gmfbo.objective import METRICS, Objective, step_metrics
from gmfbo.recordings.trial import Trial
from gmfbo.sources.models import models_folder
from gmfbo.tuning.methods import find_method

RESULTS = Path(__file__).parent / "results"
METHODS = ("gmfbo", "gmfbo_paper", "bo_ei", "random")
GRID_SIDE = 41
INITIAL_IS1, INITIAL_IS2 = 2, 10
IS1_RUNS = INITIAL_IS1 + 20
QUERIES = 100
NEVER = INITIAL_IS1 + 21
PAPER_QUERIES = 20
HORIZON = 1.0
STEP_TIME = 0.1

STUDY = """
seed = {seed}
method = "{method}"
[is1]
twin = {twin}
[is2]
twin = {twin}
parameters = {{ "map.noise" = {noise}, "map.seed" = "seed" }}
[reference]
step = 1.0
at = {at}
horizon = {horizon}
[budget]
initial_is1 = {initial}
is1_runs = {runs}
iterations = {queries}
"""


@dataclass(frozen=True)
class Outcome:
    """One method on one seed.

    Attributes
    ----------
    method, seed
        Which.
    n_star : int
        Real runs until the optimum; `NEVER` where it was not reached.
    n_star_20 : int
        The same, within 20 queries after the initial data, as the publication counts.
    real_runs, queries : int
        Made in all; the survey of the twin that a method makes at its start is no query.
    twin_runs : int
        Made in all, initial ones, survey and corrected runs included.
    seconds_a_query : float
        [s] Wall clock, simulation included.
    regret : float
        (best observed - g_min) / (g_median - g_min) at the end.
    """

    method: str
    seed: int
    n_star: int
    n_star_20: int
    real_runs: int
    queries: int
    twin_runs: int
    seconds_a_query: float
    regret: float


def drive_twin() -> Path:
    """Twin file of the drive."""
    return models_folder() / "drive_twin.toml"


def real_grid(work: Path) -> dict[str, NDArray[np.float64]]:
    """Metrics of IS1 on the grid, shape (41, 41) each; simulated once and kept."""
    with FmuTwin(drive_twin()) as twin:
        kept = work / f"real_grid_{twin.content_hash[:12]}.csv"
        if not kept.exists():
            axis = np.linspace(0.0, 1.0, GRID_SIDE)
            unit = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
            reference = step_reference(1.0, at=STEP_TIME, horizon=HORIZON)
            rows = []
            for point in twin.gains.from_unit(unit):
                run = twin.run(twin.gains.named(point), reference)
                if run.status != "ok":
                    raise SystemExit(f"IS1 failed at {point}: {run.message}")
                rows.append(
                    step_metrics(
                        run.time, run.signal("position"), step_time=STEP_TIME, horizon=HORIZON
                    )
                )
            table = np.array([[row[name] for name in METRICS] for row in rows])
            partial = kept.with_suffix(".partial")
            np.savetxt(partial, table, delimiter=",", header=",".join(METRICS), comments="")
            partial.replace(kept)
    table = np.loadtxt(kept, delimiter=",", skiprows=1)
    return {name: table[:, column] for column, name in enumerate(METRICS)}


def run_one(method: str, seed: int, noise: float, work: Path) -> Outcome:
    """Run one method on one seed, or read what it came to before."""
    kept = work / f"{method}-{seed}.json"
    if kept.exists():
        return Outcome(**json.loads(kept.read_text(encoding="utf-8")))
    folder = work / f"{method}-{seed}"
    folder.mkdir(exist_ok=True)
    file = folder / "drive.toml"
    file.write_text(
        STUDY.format(
            seed=seed,
            method=method,
            noise=noise,
            twin=json.dumps(drive_twin().as_posix()),
            at=STEP_TIME,
            horizon=HORIZON,
            initial=INITIAL_IS1,
            runs=IS1_RUNS,
            queries=QUERIES,
        ),
        encoding="utf-8",
    )
    study = Study.read(file)
    with Tuner(study) as tuner:
        began, before = time.perf_counter(), tuner.history.queries
        tuner.run()
        seconds = time.perf_counter() - began
        done = max(tuner.history.queries - before, 1)
        outcome = judge(
            tuner.history.trials,
            tuner.history.objective,
            real_grid(work),
            method,
            seed,
            seconds / done,
        )
    kept.write_text(json.dumps(asdict(outcome)), encoding="utf-8")
    return outcome


def judge(
    trials: Sequence[Trial],
    objective: Objective,
    grid: dict[str, NDArray[np.float64]],
    method: str,
    seed: int,
    seconds: float,
) -> Outcome:
    """Hold the real runs of a study against the grid, by the study's own cost."""
    truth = objective.value(grid)
    least, spread = float(truth.min()), float(np.median(truth) - truth.min())
    best, real, queries = np.inf, 0, 0
    n_star = n_star_20 = NEVER
    correction = find_method(method).correction
    initial_twin = INITIAL_IS2 + (correction.survey if correction else 0)
    twin_runs = sum(trial.source != "IS1" for trial in trials)
    for trial in trials:
        if trial.source == "IS1":
            real += 1
            queries += real > INITIAL_IS1
            # The drive twin repeats exactly: what is observed is the noise-free cost.
            best = min(best, trial.objective)
            if best <= least + 0.02 * spread:
                n_star = min(n_star, real)
                if queries <= PAPER_QUERIES:
                    n_star_20 = min(n_star_20, real)
        elif trial.source == "IS2" and trial.parent is None:
            initial_twin -= 1
            queries += initial_twin < 0
    regret = (best - least) / spread
    return Outcome(method, seed, n_star, n_star_20, real, queries, twin_runs, seconds, regret)


def table(outcomes: Sequence[Outcome], methods: Sequence[str]) -> str:
    """All seeds, and median, mean with bootstrap interval, and share that never arrived."""
    seeds = sorted({outcome.seed for outcome in outcomes})
    lines = []
    for title, field in (
        (f"n*: real runs to the optimum (never: {NEVER})", "n_star"),
        (f"the same within {PAPER_QUERIES} queries, as the publication counts", "n_star_20"),
    ):
        lines += [title, f"{'seed':>12}" + "".join(f"{method:>20}" for method in methods)]
        columns = {
            method: [
                getattr(o, field)
                for s in seeds
                for o in outcomes
                if (o.method, o.seed) == (method, s)
            ]
            for method in methods
        }
        for row, seed in enumerate(seeds):
            cells = [str(columns[m][row]) if row < len(columns[m]) else "" for m in methods]
            lines.append(f"{seed:>12}" + "".join(f"{cell:>20}" for cell in cells))
        lines.append(_row("median", [f"{np.median(columns[m]):.1f}" for m in methods]))
        lines.append(_row("mean, 95 %", [_interval(columns[m]) for m in methods]))
        never = [f"{100 * np.mean(np.array(columns[m]) == NEVER):.0f} %" for m in methods]
        lines += [_row("never", never)]
        within = [f"{sum(n <= 15 for n in columns[m])} of {len(columns[m])}" for m in methods]
        lines += [_row("n* <= 15", within), ""]
    lines.append("means over seeds")
    for label, field, form in (
        ("queries", "queries", "{:.1f}"),
        ("real runs", "real_runs", "{:.1f}"),
        ("twin runs", "twin_runs", "{:.1f}"),
        ("final regret", "regret", "{:.4f}"),
        ("s a query", "seconds_a_query", "{:.2f}"),
    ):
        means = [np.mean([getattr(o, field) for o in outcomes if o.method == m]) for m in methods]
        lines.append(_row(label, [form.format(mean) for mean in means]))
    return "\n".join(lines)


def _row(label: str, cells: Sequence[str]) -> str:
    return f"{label:>12}" + "".join(f"{cell:>20}" for cell in cells)


def _interval(values: Sequence[int]) -> str:
    sample = np.array(values, dtype=float)
    draws = np.random.default_rng(0).choice(sample, size=(4000, sample.size)).mean(axis=1)
    low, high = np.quantile(draws, [0.025, 0.975])
    return f"{sample.mean():.1f} [{low:.1f}, {high:.1f}]"


def main() -> None:
    """Run what is missing and write the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--methods", nargs="+", default=list(METHODS))
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--noise", type=float, default=0.5, help="share of the map's range")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--work", type=Path, help="folder for studies and finished pairs")
    parser.add_argument("--out", type=Path, default=RESULTS / "tuning_study.txt")
    asked = parser.parse_args()
    work = asked.work or Path(tempfile.gettempdir()) / f"gmfbo_tuning_study_{asked.noise:g}"
    work.mkdir(parents=True, exist_ok=True)
    os.nice(5)
    real_grid(work)
    jobs = [
        (method, seed)
        for seed in range(asked.first_seed, asked.first_seed + asked.seeds)
        for method in asked.methods
    ]
    outcomes = []
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(asked.processes, mp_context=context) as pool:
        futures = [pool.submit(run_one, *job, asked.noise, work) for job in jobs]
        for future in as_completed(futures):
            outcome = future.result()
            outcomes.append(outcome)
            print(f"{outcome.method} seed {outcome.seed}: n* = {outcome.n_star}", flush=True)
    text = table(outcomes, asked.methods)
    command = "python " + " ".join(["tests/benchmarks/tuning_study.py", *sys.argv[1:]])
    asked.out.parent.mkdir(exist_ok=True)
    asked.out.write_text(
        f"$ {command}\nIS2: the drive twin with {100 * asked.noise:g} % noise in its flux map\n\n"
        f"{text}\n",
        encoding="utf-8",
    )
    print(text)


if __name__ == "__main__":
    main()
