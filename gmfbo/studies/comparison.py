"""Tuning methods compared on the same seeds of one study."""

from __future__ import annotations

import hashlib
import json
import shlex
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import gmfbo.retuning  # noqa: F401 - adds its methods
from gmfbo import __version__
from gmfbo.errors import InputError, StoreError
from gmfbo.studies.comparison_folder import ComparisonFolder
from gmfbo.studies.curves import read_curves
from gmfbo.studies.landscape import landscape_of, read_landscape
from gmfbo.studies.one_run import OneRun, seeded
from gmfbo.studies.outcome import Outcome
from gmfbo.studies.plant_grid import TrueSources
from gmfbo.studies.run_pool import run_all
from gmfbo.tuning.method import Method
from gmfbo.tuning.methods import METHODS, find_method
from gmfbo.tuning.study import Study

Told = Callable[[str], None]

GRID_SIDE = 41


@dataclass(frozen=True)
class Comparison:
    """What methods came to on the same seeds.

    Attributes
    ----------
    folder : Path
        Where it is kept.
    text : str
        Its tables.
    outcomes : tuple of Outcome
        All finished runs, those of former calls too; empty where only the tables were read.
    failed : mapping of str to str
        `METHOD-SEED` of runs of this call that broke, with the reason.
    """

    folder: Path
    text: str = field(repr=False)
    outcomes: tuple[Outcome, ...] = field(default=(), repr=False)
    failed: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def read(cls, folder: str | Path) -> Self:
        """Read the tables of a comparison; its runs need not be there.

        Parameters
        ----------
        folder : str or Path
            What `compare` wrote.

        Raises
        ------
        StoreError
            There are none.
        """
        kept = ComparisonFolder(Path(folder))
        try:
            return cls(kept.path, kept.table.read_text(encoding="utf-8"))
        except OSError:
            raise StoreError(
                f"{folder}: expected the folder of a comparison, with its table.txt; make it with "
                "'gmfbo compare STUDY.toml --out FOLDER'"
            ) from None

    def draw(self, folder: str | Path) -> list[Path]:
        """Draw the figures from the tables: landscape, sampling cost, best observed.

        Parameters
        ----------
        folder : str or Path
            Where the SVG, PDF and PNG files go.

        Returns
        -------
        list of Path
            Of the SVG files.

        Raises
        ------
        StoreError
            The tables are not there.
        InputError
            matplotlib is not installed.
        """
        kept = ComparisonFolder(self.folder)
        curves, landscape = read_curves(kept.curves), read_landscape(kept.landscape)
        from gmfbo.reports.comparison_figures import draw_comparison

        return draw_comparison(curves, landscape, Path(folder))

    def __str__(self) -> str:
        return self.text


def compare(
    study: str | Path,
    methods: Sequence[str | Method] = (),
    seeds: int = 10,
    *,
    first_seed: int = 0,
    out: str | Path | None = None,
    jobs: int = 1,
    grid: int = GRID_SIDE,
    progress: Told | None = None,
) -> Comparison:
    """Run methods on the same seeds of a study, and hold each against the plant's true optimum.

    Each finished run is kept at once: a call that was stopped or killed goes on where it was,
    and a later call with more seeds or methods adds to the tables.

    Parameters
    ----------
    study : str or Path
        Study file whose plant is an FMU; its `seed` and `method` are not looked at. Its budget
        holds for every method.
    methods : sequence of str or Method
        Names, `NAME:N` for another number of seeds, or methods of your own; none means all.
    seeds : int
        Seeds of each method.
    first_seed : int
        The first of them.
    out : str or Path, optional
        Folder; `STUDY.compare` beside the study file unless given.
    jobs : int
        Processes. With more than one, a script must guard its start by
        `if __name__ == "__main__":`.
    grid : int
        Points along a side of the grid of gains that gives the true optimum.
    progress : callable, optional
        Told in a line of each finished run.

    Raises
    ------
    InputError
        A method is unknown, a number is too small, the plant is no FMU, or the folder is of
        another study.
    """
    path = Path(study)
    _check(seeds=(seeds, 1), first_seed=(first_seed, 0), jobs=(jobs, 1), grid=(grid, 3))
    wanted = _wanted(methods or list(METHODS), seeds)
    told = progress or (lambda line: None)
    given = Study.read(path)
    if given.file.earlier is not None:
        raise InputError(
            f"{path}: expected a study without earlier runs, got earlier = "
            f"'{given.file.earlier}'; a comparison lets every method begin from nothing"
        )
    folder = ComparisonFolder(Path(out) if out else path.with_suffix(".compare"))
    with folder.writing():
        key = study_key(given, grid)
        outcomes = folder.outcomes(key)
        heading = [
            f"$ {line}"
            for line in folder.log_command(_command(path, out, wanted, seeds, first_seed, grid))
        ]
        _tell_the_truth(given, first_seed, grid, folder.path, told)
        have = {(one.method, one.seed) for one in outcomes}
        runs = [
            OneRun(given, key, method, seed, folder.path, grid)
            for seed in range(first_seed, first_seed + max(count for _, count in wanted))
            for method, count in wanted
            if seed < first_seed + count and (method.name, seed) not in have
        ]
        failed = _make(runs, jobs, outcomes, told)
        if not outcomes:
            return Comparison(folder.path, "no run finished\n", failed=failed)
        landscape = read_landscape(folder.landscape)
        if landscape is None:
            lowest = min(one.seed for one in outcomes)
            landscape = landscape_of(given, lowest, grid, folder.path, told)
        heading += [f"{given.file.name}, gmfbo {__version__}"]
        heading += [f"no result: {label}: {reason}" for label, reason in sorted(failed.items())]
        text = folder.write_tables(outcomes, heading, landscape)
    return Comparison(folder.path, text, tuple(outcomes), failed)


def study_key(study: Study, grid: int) -> str:
    """Hash of all that the runs of a comparison share.

    Parameters
    ----------
    study : Study
        As given; name, folder, method and seed do not count.
    grid : int
        Points along a side.
    """
    # The twins' hashes hold the seed where the study file says so, hence always that of seed 0.
    first = seeded(study, 0, study.file.method, study.location)
    parts = first.file.model_dump(mode="json", exclude={"name", "out", "method", "seed", "earlier"})
    for source in ("is1", "is2"):
        parts[source].pop("twin", None)  # its content counts, wherever it lies
    opened = TrueSources.open(first)
    with closing(opened.sources):
        parts["content"] = opened.sources.content_hashes
    parts["grid"] = grid
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def _check(**numbers: tuple[int, int]) -> None:
    for name, (value, least) in numbers.items():
        if value < least:
            raise InputError(f"{name.replace('_', '-')}: expected at least {least}, got {value}")


def _wanted(methods: Sequence[str | Method], seeds: int) -> list[tuple[Method, int]]:
    """Each method with its number of seeds."""
    wanted: list[tuple[Method, int]] = []
    for method in methods:
        if not isinstance(method, str):
            wanted.append((method, seeds))
            continue
        name, colon, count = method.strip().partition(":")
        if colon and not (count.isdecimal() and int(count) > 0):
            raise InputError(f"methods: expected NAME:SEEDS, such as {name}:10, got '{method}'")
        wanted.append((find_method(name), int(count) if colon else seeds))
    names = [method.name for method, _ in wanted]
    if len(set(names)) < len(names):
        raise InputError(f"methods: expected each once, got {','.join(names)}")
    return wanted


def _command(
    path: Path,
    out: str | Path | None,
    wanted: Sequence[tuple[Method, int]],
    seeds: int,
    first_seed: int,
    grid: int,
) -> str:
    """The command that makes these runs; what does not change them is left out."""
    named = ",".join(m.name if count == seeds else f"{m.name}:{count}" for m, count in wanted)
    parts = ["gmfbo", "compare", path.as_posix(), "--seeds", str(seeds), "--methods", named]
    if first_seed:
        parts += ["--first-seed", str(first_seed)]
    if grid != GRID_SIDE:
        parts += ["--grid", str(grid)]
    if out is not None:
        parts += ["--out", Path(out).as_posix()]
    return shlex.join(parts)


def _tell_the_truth(study: Study, seed: int, grid: int, folder: Path, told: Told) -> None:
    """Simulate the plant over the box before the runs, so that no two processes do it at once."""
    opened = TrueSources.open(seeded(study, seed, study.file.method, study.location))
    with closing(opened.sources):
        for plant in opened.plants:
            opened.grid(plant, grid, folder / "truth", told)


def _make(runs: Sequence[OneRun], jobs: int, outcomes: list[Outcome], told: Told) -> dict[str, str]:
    """Make what is missing, add it to the outcomes, and return what failed."""
    failed: dict[str, str] = {}
    done = 0

    def finished(run: OneRun, came: Outcome | str) -> None:
        nonlocal done
        done += 1
        head = f"{done} of {len(runs)}: {run.method.name}, seed {run.seed}:"
        if isinstance(came, str):
            failed[run.label] = came
            told(f"{head} failed: {came}")
            return
        outcomes.append(came)
        arrived = "never" if came.n_star is None else str(came.n_star)
        spent = came.seconds_before + sum(came.seconds)
        told(f"{head} n* {arrived}, {len(came.regret)} real runs, {spent:.0f} s")

    run_all(runs, jobs, finished)
    return failed
