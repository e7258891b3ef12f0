"""Makes the studies of the benchmark, one line of text each; a killed run goes on.

    python -m tests.benchmarks.plants.run --methods A,B --seeds 0:3 [--plants P,Q] [--out DIR]

A study whose line is in the folder is not made again. Lines lie in `METHOD.jsonl` of each plant.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import gmfbo.retuning  # noqa: F401 - adds its methods
from gmfbo.recordings.store.memory_store import MemoryStore
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.tuning.history.history import History
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods import find_method
from gmfbo.tuning.query.method import Method, Proposal
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from gmfbo.version import __version__
from tests.benchmarks.plants.axis import PlantAxis
from tests.benchmarks.plants.catalogue import HERE, PLANTS, Plant
from tests.benchmarks.plants.judge import Judge
from tests.benchmarks.plants.side.rivals import RIVALS

RESULTS = HERE / "results"
METHODS = ",".join(
    (
        "gmfbo_physics",
        "gmfbo_estimated",
        "bo_ei",
        "log_ei",
        "identify_then_optimise",
        "gmfbo",
        "twin_once",
        "textbook_rule",
    )
)


@dataclass(eq=False)
class Line:
    """What one study came to.

    Attributes
    ----------
    gains, cost, status : list
        Of each real run: gains in order, observed cost g, and how it ended (`ok` runs that did
        not settle are `unsettled`).
    twin_before : list of int
        Twin runs, corrected ones included, that were made before each real run.
    recommended, true : list
        After each real run from the last initial one on: gains, or None; their noise-free cost g,
        None where it is infinite.
    seconds, processor_s : float
        [s] Wall clock and processor time of the study, its workers' included.
    recommend_seconds : float
        [s] Processor time of judging recommendations, which is in neither.
    """

    plant: str
    method: str
    seed: int
    initial: int
    command: str
    commit: str
    version: str = __version__
    gains: list[list[float]] = field(default_factory=list)
    cost: list[float] = field(default_factory=list)
    status: list[str] = field(default_factory=list)
    twin_before: list[int] = field(default_factory=list)
    recommended: list[list[float] | None] = field(default_factory=list)
    true: list[float | None] = field(default_factory=list)
    motion_s: float = 0.0
    twin_runs: int = 0
    seconds: float = 0.0
    processor_s: float = 0.0
    recommend_seconds: float = 0.0
    stopped: str = ""


def seeded(study: Study, seed: int, method: str, place: Path) -> Study:
    """Copy of a plant's study for one seed and method, in memory."""
    changes: dict[str, Any] = {"seed": seed, "method": method}
    if method == "gmfbo_paper":  # as printed, which has no watch
        changes["drift"] = study.file.drift.model_copy(update={"watch": False})
    file = study.file.model_copy(update=changes)
    return replace(study, file=file, location=place / "run.study")


def method_of(name: str, plant: Plant, initial: int, seed: int) -> Method:
    """A method of gmfbo, or a peer of this benchmark, by name."""
    made = RIVALS.get(name)
    return made(plant, initial, seed) if made else find_method(name)


def make(judge: Judge, method: str, seed: int, line: Line, *, judged: bool = True) -> Line:
    """Run one study and judge what it recommends after each real run.

    Parameters
    ----------
    judge : Judge
        Of the plant.
    method : str
        Its name.
    seed : int
        Of the study and of the plant's noise.
    line : Line
        With what is known before; it is filled.
    judged : bool
        Whether recommendations are asked for; False measures the time of a study alone.
    """
    with tempfile.TemporaryDirectory(prefix="gmfbo-plants-") as place:
        study = seeded(judge.study, seed, method, Path(place))
        axis = PlantAxis(judge.plant, seed)
        store = MemoryStore(study.location, study.text)
        began, used = time.perf_counter(), processor_s()
        chosen = method_of(method, judge.plant, line.initial, seed)
        watched = RecommendingMethod(chosen, line.initial if judged else None)
        with Tuner(study, is1=axis, method=watched, store=store) as tuner:
            try:
                tuner.run()
            except Exception as error:
                line.stopped = " ".join(f"{type(error).__name__}: {error}".split())
            line.seconds = time.perf_counter() - began - watched.seconds
            line.processor_s = processor_s() - used - watched.processor_s
            line.twin_runs = len(tuner.history.of("IS2"))
            _note_runs(tuner.history, judge, line)
            if judged:
                _judge(tuner.history, watched, judge, line)
        axis.close()
    line.recommend_seconds = processor_s() - used - line.processor_s
    return line


@dataclass(eq=False)
class RecommendingMethod:
    """Notes what a method would recommend, whenever it is asked to propose.

    By then the twin has made all runs that the last real run causes, as at the end of a study.

    Attributes
    ----------
    method : Method
        What is watched; all its other properties are those of this one.
    initial : int or None
        Real runs from which on it is asked; None never asks.
    points : dict of int to ndarray or None
        By number of real runs: gains in the unit cube, None where none are recommended.
    seconds, processor_s : float
        [s] Spent on it, which is no part of a study.
    """

    method: Method
    initial: int | None
    points: dict[int, NDArray[np.float64] | None] = field(default_factory=dict)
    seconds: float = 0.0
    processor_s: float = 0.0

    def __getattr__(self, name: str) -> Any:
        return getattr(self.method, name)

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal | None:
        """Note the recommendation, and propose."""
        began, used = time.perf_counter(), processor_s()
        self.note(state)
        self.seconds += time.perf_counter() - began
        self.processor_s += processor_s() - used
        return self.method.propose(state, rng)

    def note(self, state: TuningState) -> None:
        """Note what is recommended now."""
        real = len(state.of("IS1"))
        if self.initial is not None and real >= self.initial:
            settled = any(one.settled for one in state.of("IS1"))
            self.points[real] = self.method.recommend(state)[0] if settled else None


def _note_runs(history: History, judge: Judge, line: Line) -> None:
    """Add all real runs."""
    twins = 0
    for trial in history.trials:
        if trial.source != "IS1":
            twins += 1
            continue
        line.twin_before.append(twins)
        settled = (trial.late_error or 0.0) <= 1.0
        line.gains.append([trial.gains[name] for name in judge.gains.space.names])
        line.cost.append(float(f"{trial.objective:.6g}"))
        line.status.append("unsettled" if trial.status == "ok" and not settled else trial.status)
        line.motion_s += float(trial.recording.time[-1] - trial.recording.time[0])


def _judge(history: History, watched: RecommendingMethod, judge: Judge, line: Line) -> None:
    """Add the noise-free cost of what was recommended after each real run."""
    watched.note(history.state({}))
    known: dict[tuple[float, ...], float] = {}
    for count in range(line.initial, len(line.gains) + 1):
        # A run that the study repeats by itself is not proposed, and changes no recommendation.
        unit = watched.points.setdefault(count, watched.points.get(count - 1))
        if unit is None:
            line.recommended.append(None)
            line.true.append(None)
            continue
        point = judge.gains.space.from_unit(unit)
        key = tuple(point.tolist())
        known[key] = true = known[key] if key in known else judge.true_cost(point)
        line.recommended.append([float(f"{v:.6g}") for v in point])
        line.true.append(float(f"{true:.6g}") if abs(true) < float("inf") else None)


def processor_s() -> float:
    """[s] Processor time of this process, and of workers that have ended."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def finished(path: Path) -> set[int]:
    """Seeds that a file has a line of; a line cut off by a kill does not count, and is removed."""
    if not path.exists():
        return set()
    good, lines = [], path.read_text(encoding="utf-8").splitlines()
    for text in lines:
        try:
            json.loads(text)
        except ValueError:
            continue
        good.append(text)
    if good != lines:  # another process may read it now
        path.write_text("".join(f"{text}\n" for text in good), encoding="utf-8")
    return {int(json.loads(text)["seed"]) for text in good}


def commit() -> str:
    """Commit of this checkout, with a plus where files differ from it."""
    said = subprocess.run(
        ["git", "describe", "--always", "--dirty=+", "--abbrev=12", "--exclude=*"],
        cwd=HERE,
        capture_output=True,
        text=True,
        check=False,
    )
    return said.stdout.strip() or "unknown"


def run_all(plants: Sequence[str], methods: Sequence[str], seeds: range, out: Path) -> None:
    """Make all studies that are missing, seed by seed, so that what is there is balanced."""
    run_plants([PLANTS[name] for name in plants], methods, seeds, out)


def run_plants(
    plants: Sequence[Plant], methods: Sequence[str], seeds: Sequence[int], out: Path
) -> None:
    """The same for plants that need not be those of the catalogue."""
    # Results of this benchmark are no part of what made them.
    known = commit()
    module = Path(sys.argv[0]).stem
    command = f"python -m tests.benchmarks.plants.{module} " + " ".join(sys.argv[1:])
    for seed in seeds:
        for plant in plants:
            name = plant.name
            missing = [m for m in methods if seed not in finished(out / name / f"{m}.jsonl")]
            if not missing:
                continue
            with Judge.open(plant) as judge:
                initial = judge.study.file.budget.initial_is1
                for method in missing:
                    line = Line(name, method, seed, initial, command, known)
                    _keep(out / name / f"{method}.jsonl", asdict(make(judge, method, seed, line)))
                    print(
                        f"{name} {method} {seed}: {line.seconds:.0f} s {line.stopped}", flush=True
                    )


def _keep(path: Path, line: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    for name in ("seconds", "processor_s", "recommend_seconds", "motion_s"):
        line[name] = round(line[name], 2)
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(line) + "\n")


def in_this_process() -> None:
    """Run all FMUs in this process: on a busy machine each turn of a worker is waited for."""
    for twin in (FmuTwin, AugmentedTwin):
        twin.__init__.__kwdefaults__["isolated"] = False  # type: ignore[index]


def main() -> None:
    """Read the arguments, and run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plants", default=",".join(PLANTS))
    parser.add_argument("--methods", default=METHODS)
    parser.add_argument("--seeds", default="20:40", help="FIRST:END")
    parser.add_argument("--out", type=Path, default=RESULTS)
    options = parser.parse_args()
    in_this_process()
    first, _, end = options.seeds.partition(":")
    seeds = range(int(first), int(end))
    run_all(options.plants.split(","), options.methods.split(","), seeds, options.out)


if __name__ == "__main__":
    main()
