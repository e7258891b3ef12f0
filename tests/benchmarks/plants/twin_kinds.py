"""Studies with twins that mislead, and with perfect ones, on four of the plants.

    python -m tests.benchmarks.plants.twin_kinds [--kinds A,B] [--plants P,Q] [--seeds 20:30]

A study whose line is there is not made again; lines lie in `results/twin_kinds/KIND/PLANT/`. The
table at the end takes `bo_ei` on the same seeds from `results/`: it never asks the twin.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.files.durable import write_whole
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin import augmented_twin, twin
from gmfbo.sources.twin.parameter_values import RunParameters, run_parameters
from gmfbo.sources.twin.twin import FmuTwin
from tests.benchmarks.plants.arrival import Arrivals, read_lines
from tests.benchmarks.plants.catalogue import PLANTS, Plant
from tests.benchmarks.plants.judge import Judge
from tests.benchmarks.plants.make_truth import truth_text
from tests.benchmarks.plants.run import RESULTS, in_this_process, run_plants
from tests.benchmarks.plants.targets import Target, read_targets, target_of
from tests.benchmarks.plants.truths.conditions import Conditions, Vector

OURS = "gmfbo_estimated"

KINDS = ("useless", "opposed", "far_off", "perfect")

CHOSEN = ("drive_twin", "linear_axis", "temperature", "mujoco_belt")
"""Those on which `bo_ei` arrives most often at 5 %: elsewhere nothing can be lost against it."""

FOLDER = RESULTS / "twin_kinds"
PERFECT = FOLDER / "perfect.json"
"""Targets of the plants that the twin itself plays."""

NOISE = {
    "drive_twin": {},  # its study file states it
    "linear_axis": {"position": 2e-5, "drive_voltage": 0.01},
    "temperature": {"temperature": 0.03},
    "mujoco_belt": {"position": 2e-3, "current": 0.01},
}
"""Standard deviations of what a perfect twin's plant measures, as those of the plant itself."""


@dataclass(frozen=True)
class TwinItself:
    """Plays the twin at its own values: the plant of a perfect twin.

    Its friction does not differ from run to run, since the twin's does not.
    """

    name: str

    def __call__(
        self, gains: Mapping[str, float], reference: Recording, conditions: Conditions
    ) -> dict[str, Vector]:
        """Columns of a run."""
        with FmuTwin(PLANTS[self.name].folder / "twin.toml", isolated=False) as itself:
            run = itself.run(gains, reference)
        noise = NOISE[self.name]
        columns = {
            name: values + conditions.noise(noise.get(name, 0.0), len(run.time))
            for name, values in run.signals.items()
        }
        return {"time": run.time, **columns}


def of_kind(plant: Plant, kind: str) -> Plant:
    """The plant with a twin of a kind."""
    if kind == "far_off":
        return replace(plant, twin="twin_far_off.toml")
    if kind == "perfect":
        return replace(plant, truth=TwinItself(plant.name), package="")
    return plant


@contextmanager
def other_gains(plant: Plant, kind: str) -> Iterator[None]:
    """Within it the plant's twin runs at other gains than it is asked for.

    A useless twin runs at the gains in force, whatever is asked; an opposed one at those mirrored
    in the box. What it answers names the gains that were asked for.
    """
    if kind not in ("useless", "opposed"):
        yield
        return
    study = plant.study()
    with FmuTwin(plant.folder / study.file.is2.twin, isolated=False) as opened:
        own = opened.file.name
    with Judge.open(plant) as judge:
        space, in_force = judge.gains.space, judge.in_force

    def mapped(values: Mapping[str, float]) -> dict[str, float]:
        if kind == "useless":
            point = in_force
        else:
            unit = space.to_unit(np.array([values[name] for name in space.names]))
            point = space.from_unit(1.0 - unit)
        return dict(zip(space.names, map(float, point), strict=True))

    def chosen(
        binding: Any,
        recording: Recording,
        override: Mapping[str, float],
        gains: Mapping[str, float],
        texts: Mapping[str, str] | None = None,
    ) -> RunParameters:
        known = {**recording.parameters, **override, **gains}
        if binding.file.name != own or not set(space.names) <= set(known):
            return run_parameters(binding, recording, override, gains, texts)
        asked = {name: known[name] for name in space.names}
        run = run_parameters(binding, recording, override, {**gains, **mapped(asked)}, texts)
        return replace(run, in_force={**run.in_force, **asked})

    places: tuple[Any, ...] = (twin, augmented_twin)
    for place in places:
        place.run_parameters = chosen
    try:
        yield
    finally:
        for place in places:
            place.run_parameters = run_parameters


def perfect_targets(names: Sequence[str]) -> dict[str, Target]:
    """Targets of the plants that their twins play; kept, since they take a minute a plant."""
    raw: dict[str, Any] = json.loads(PERFECT.read_text("utf-8")) if PERFECT.exists() else {}
    for name in names:
        if name in raw:
            continue
        with Judge.open(of_kind(PLANTS[name], "perfect")) as judge:
            raw[name] = asdict(target_of(judge, truth_text(judge)))
        PERFECT.parent.mkdir(parents=True, exist_ok=True)
        write_whole(PERFECT, (json.dumps(raw, indent=1) + "\n").encode())
    return {name: Target(**raw[name]) for name in names}


def runs_of(
    kind: str, folder: Path = FOLDER, share: float = 0.05
) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Runs to target with a kind of twin, and those of `bo_ei` on the same seeds, by plant.

    Parameters
    ----------
    kind : str
        Of the twin.
    folder : Path
        Of the lines.
    share : float
        Of the way to the optimum that may be left.

    Returns
    -------
    dict of str to tuple of ndarray
        Both of shape (seeds,); `bo_ei` has none on the plant of a perfect twin.
    """
    lines = read_lines(folder / kind)
    plants = [name for name in CHOSEN if any(line["plant"] == name for line in lines)]
    targets = perfect_targets(plants) if kind == "perfect" else read_targets()
    aims = {name: targets[name].cost(share) for name in plants}
    own, alone = Arrivals.of(lines, aims), Arrivals.of(read_lines(RESULTS), aims)
    found = {}
    for name in plants:
        seeds = sorted(own.runs[name, OURS])
        if kind != "perfect":
            seeds = [seed for seed in seeds if seed in alone.runs[name, "bo_ei"]]
        peer = alone.capped(name, "bo_ei", seeds if kind != "perfect" else [])
        found[name] = (own.capped(name, OURS, seeds), peer)
    return found


def table(folder: Path = FOLDER) -> str:
    """Runs to target with each kind, and how many more than `bo_ei` needs."""
    rows = [f"runs to target at 5 %, mean: of {OURS}, of bo_ei, and how many more"]
    for kind in KINDS:
        found = runs_of(kind, folder)
        for name, (own, peer) in found.items():
            told = f"{kind:8s} {name:12s} {own.mean():5.1f}"
            if peer.size:
                told += f"   {peer.mean():5.1f}   {(own - peer).mean():+5.1f}"
            rows.append(told)
        lost = [float((own - peer).mean()) for own, peer in found.values() if peer.size]
        if lost:
            rows.append(f"{kind:8s} mean loss {np.mean(lost):+.1f} runs")
        elif found:
            runs = np.concatenate([own for own, _ in found.values()])
            rows.append(f"{kind:8s} median {np.median(runs):g} runs")
    return "\n".join(rows) + "\n"


def main() -> None:
    """Make the studies that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--plants", default=",".join(CHOSEN))
    parser.add_argument("--methods", default=OURS)
    parser.add_argument("--seeds", default="20:30", help="FIRST:END")
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args()
    in_this_process()
    first, _, end = options.seeds.partition(":")
    names, methods = options.plants.split(","), options.methods.split(",")
    perfect_targets(names if "perfect" in options.kinds else [])
    for seed in range(int(first), int(end)):
        for kind in options.kinds.split(","):
            for name in names:
                plant = of_kind(PLANTS[name], kind)
                with other_gains(plant, kind):
                    run_plants([plant], methods, [seed], options.out / kind)
    print(table(options.out), end="")


if __name__ == "__main__":
    main()
