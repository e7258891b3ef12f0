"""Planned comparison: missing runs as units of work, and their results."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import Self

from gmfbo.errors import InputError
from gmfbo.studies.comparison_folder import ComparisonFolder
from gmfbo.studies.landscape import landscape_of, read_landscape
from gmfbo.studies.one_run import seeded, seeded_file
from gmfbo.studies.outcome import Outcome
from gmfbo.studies.plant_grid import TrueSources
from gmfbo.studies.study_files import Gathered, gather, plant_files, seeds_apart
from gmfbo.studies.unit import Failed, Made, Unit
from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.query.method import Method
from gmfbo.tuning.study.study import Study
from gmfbo.version import __version__


@dataclass(frozen=True, eq=False)
class Wanted:
    """Runs that a comparison shall hold.

    Attributes
    ----------
    methods : tuple of (Method, int)
        Each method with its number of seeds.
    first_seed : int
        The first of them.
    grid : int
        Points along a side of the grid of gains that gives the true optimum.
    keep_trials : bool
        Whether every trial of every run is kept, not only the outcome.
    """

    methods: tuple[tuple[Method, int], ...]
    first_seed: int
    grid: int
    keep_trials: bool

    @property
    def seeds(self) -> range:
        """All seeds of any method."""
        most = max(count for _, count in self.methods)
        return range(self.first_seed, self.first_seed + most)

    def runs(self) -> Iterator[tuple[Method, int]]:
        """Each method and seed, all methods of a seed before the next seed."""
        for seed in self.seeds:
            for method, count in self.methods:
                if seed < self.first_seed + count:
                    yield method, seed


@dataclass(eq=False)
class PlannedComparison:
    """A comparison with its folder locked for writing.

    Attributes
    ----------
    study : Study
        As given.
    folder : ComparisonFolder
        Its folder.
    wanted : Wanted
        Its runs.
    key : str
        Hash of the content that the runs share.
    gathered : Gathered
        All files of the study; workers may lack these, and the grids.
    outcomes : list of Outcome
        Finished runs, also of former calls.
    failed : dict of str to str
        `METHOD-SEED` of failed runs of this call, with the reason.
    """

    study: Study
    folder: ComparisonFolder
    wanted: Wanted
    key: str
    gathered: Gathered
    outcomes: list[Outcome]
    failed: dict[str, str] = field(default_factory=dict)
    _grids: dict[str, str] = field(default_factory=dict)
    _named: dict[int, frozenset[str]] = field(default_factory=dict)

    @classmethod
    def begin(cls, study: Study, folder: ComparisonFolder, wanted: Wanted) -> Self:
        """Read the finished runs, and plan the rest.

        Raises
        ------
        InputError
            The study begins with earlier runs, or nothing tells the truth of its plant.
        StoreError
            The folder holds runs of another study.
        """
        if study.file.earlier is not None:
            raise InputError(
                f"{study.origin / study.file.name}: expected a study without earlier runs, got "
                f"earlier = '{study.file.earlier}'; a comparison lets every method begin from "
                "nothing"
            )
        key = _study_key(study, wanted.grid)
        planned = cls(study, folder, wanted, key, gather(study), folder.outcomes(key))
        planned._read({path.name: path.read_bytes() for path in folder.truth.glob("*.csv")})
        return planned

    @property
    def name(self) -> str:
        """Name of the study."""
        return self.study.file.name

    @property
    def label(self) -> str:
        """Prefix that distinguishes its units from those of other comparisons."""
        return self.folder.path.resolve().as_posix()

    def truths(self) -> list[Unit]:
        """Units that run the plant over the box, for seeds without a grid yet."""
        seeds = sorted({seed for _, seed in self._lacking()})
        if not seeds_apart(self.study):
            seeds = seeds[:1]
        unknown = [seed for seed in seeds if not self._names(seed) <= self._grids.keys()]
        return [self._unit(f"truth-{seed}", None, seed) for seed in unknown]

    def runs(self) -> list[Unit]:
        """Units of the missing runs; the grids of the plant are known by now."""
        return [
            self._unit(f"{method.name}-{seed}", method, seed) for method, seed in self._lacking()
        ]

    def take(self, unit: Unit, came: Made | Failed) -> str:
        """Keep the result of a unit, and describe it in a line."""
        name = unit.label.rpartition(": ")[2]
        method, _, seed = name.rpartition("-")
        head = f"{method if unit.method else 'the plant'}, seed {seed}:"
        if isinstance(came, Failed):
            self.failed[name] = came.reason
            return f"{head} failed: {came.reason}"
        self.folder.keep_truth(came.truth)
        self._read(came.truth)
        one = came.outcome
        if one is None:
            return f"{head} run all over the box, once"
        self.folder.keep(one, came.record)
        self.outcomes.append(one)
        arrived = "never" if one.n_star is None else str(one.n_star)
        spent = one.seconds_before + sum(one.seconds)
        return f"{head} n* {arrived}, {len(one.regret)} real runs, {spent:.0f} s"

    def tables(self, heading: Sequence[str]) -> str:
        """Write the tables of all finished runs."""
        if not self.outcomes:
            return "no run finished\n"
        landscape = read_landscape(self.folder.landscape)
        if landscape is None:
            lowest = min(one.seed for one in self.outcomes)
            landscape = landscape_of(self.study, lowest, self.wanted.grid, self.folder.truth)
        lines = [*heading, f"{self.name}, gmfbo {__version__}"]
        lines += [f"no result: {label}: {why}" for label, why in sorted(self.failed.items())]
        return self.folder.write_tables(self.outcomes, lines, landscape)

    def _read(self, grids: Mapping[str, bytes]) -> None:
        for name, content in grids.items():
            digest = hashlib.sha256(content).hexdigest()
            self._grids[name] = digest
            self.gathered.contents[digest] = content

    def _lacking(self) -> list[tuple[Method, int]]:
        have = {(one.method, one.seed) for one in self.outcomes}
        return [(m, seed) for m, seed in self.wanted.runs() if (m.name, seed) not in have]

    def _names(self, seed: int) -> frozenset[str]:
        same = seed if seeds_apart(self.study) else 0
        if same not in self._named:
            study = seeded(self.study, same, self.study.file.method, self.study.location)
            opened = TrueSources.open(study)
            with closing(opened.sources):
                self._named[same] = frozenset(
                    opened.file_name(plant, self.wanted.grid) for plant in opened.plants
                )
        return self._named[same]

    def _unit(self, name: str, method: Method | None, seed: int) -> Unit:
        file = seeded_file(
            self.gathered.files.file, seed, method.name if method else self.study.file.method
        )
        # The name is enough if workers know the method by it.
        known = method is not None and METHODS.get(method.name) is method
        return Unit(
            label=f"{self.label}: {name}",
            files=replace(self.gathered.files, file=file),
            truth={name: self._grids[name] for name in self._names(seed) if name in self._grids},
            method=method.name if method and known else method,
            key=self.key,
            side=self.wanted.grid,
            keep=self.wanted.keep_trials,
            version=__version__,
        )


def _study_key(study: Study, grid: int) -> str:
    """Hash of all that the runs share; name, folder, method and seed do not count."""
    # The twins' hashes hold the seed where the study file says so, hence always that of seed 0.
    first = seeded(study, 0, study.file.method, study.location)
    apart = {"name", "out", "method", "seed", "earlier", "compare"}
    parts = first.file.model_dump(mode="json", exclude=apart)
    for source in ("is1", "is2"):
        parts[source].pop("twin", None)  # the twin's content counts, not its path
    # Keys of later versions count where they are used, so that older comparisons go on.
    if parts["is1"]["function"] is None:
        parts["is1"].pop("function")
    if first.file.compare.truth is not None:
        files = [study.origin / first.file.compare.truth, *plant_files(study)]
        parts["truth"] = [hashlib.sha256(path.read_bytes()).hexdigest() for path in files]
    opened = TrueSources.open(first)
    with closing(opened.sources):
        parts["content"] = opened.sources.content_hashes
    parts["grid"] = grid
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]
