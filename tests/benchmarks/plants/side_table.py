"""Rivals that others made, other noise, and variants of ours, on four of the plants.

    python -m tests.benchmarks.plants.side_table [--parts A,B] [--plants P,Q] [--seeds 20:30]

A study whose line is there is not made again; lines lie in `results/side/PART/PLANT/`. `ax` wants
the package ax-platform, which no extra brings.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tests.benchmarks.plants.catalogue import PLANTS, Plant
from tests.benchmarks.plants.run import RESULTS, in_this_process, run_plants
from tests.benchmarks.plants.safety import LIMITED, with_envelope
from tests.benchmarks.plants.twin_kinds import CHOSEN

FOLDER = RESULTS / "side"

OURS = "gmfbo_estimated"

NOISE = (0.3, 3.0)
"""Factors of the noise, and of how much friction differs from run to run."""


def _as_it_is(plant: Plant) -> Plant:
    return plant


def noisier(factor: float) -> Callable[[Plant], Plant]:
    """The plant with other noise."""
    return lambda plant: replace(plant, noise=factor)


@dataclass(frozen=True)
class Part:
    """Studies that are compared with each other, and with those of the main table.

    Attributes
    ----------
    methods, plants : tuple of str
        By name.
    changed : callable
        From a plant of the catalogue to the one that is run.
    """

    methods: tuple[str, ...]
    plants: tuple[str, ...] = CHOSEN
    changed: Callable[[Plant], Plant] = _as_it_is


PARTS: Mapping[str, Part] = {
    "rivals": Part(("ax", "nelder_mead", "gmfbo_paper", "gmfbo_calibrated")),
    "is3": Part(("is3_source", "is3_none")),
    "turbo": Part(("turbo",), ("six_gains",)),
    "envelope": Part((OURS, "bo_ei", "constrained_ei"), LIMITED, with_envelope),
    **{
        f"noise_{factor:g}": Part((OURS, "bo_ei", "log_ei"), changed=noisier(factor))
        for factor in NOISE
    },
    "knowledge_gradient": Part(("mfbo_takg",)),
}


def make(part: str, plants: Sequence[str], seeds: range, out: Path) -> None:
    """Make the studies of a part that are missing."""
    one = PARTS[part]
    changed = [one.changed(PLANTS[name]) for name in one.plants if name in plants or not plants]
    run_plants(changed, one.methods, seeds, out / part)


def main() -> None:
    """Make the studies that are missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", default=",".join(PARTS))
    parser.add_argument("--plants", default="")
    parser.add_argument("--seeds", default="20:30", help="FIRST:END")
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args()
    in_this_process()
    first, _, end = options.seeds.partition(":")
    plants = options.plants.split(",") if options.plants else []
    for seed in range(int(first), int(end)):
        for part in options.parts.split(","):
            make(part, plants, range(seed, seed + 1), options.out)


if __name__ == "__main__":
    main()
