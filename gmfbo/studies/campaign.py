"""Comparisons of one study or of many, on any engine."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gmfbo.retuning  # noqa: F401 - adds its methods
from gmfbo.errors import InputError
from gmfbo.studies.comparison import Comparison
from gmfbo.studies.comparison_folder import ComparisonFolder
from gmfbo.studies.dispatch import Dispatch
from gmfbo.studies.engine import Engine, InProcess, OnExecutor, Processes
from gmfbo.studies.planned_comparison import PlannedComparison, Wanted
from gmfbo.studies.unit import Failed, Made, Unit
from gmfbo.studies.variants import variants, variation_text
from gmfbo.tuning.methods import METHODS, find_method
from gmfbo.tuning.query.method import Method
from gmfbo.tuning.study.study import Study

Told = Callable[[str], None]

GRID_SIDE = 41


def compare(
    study: str | Path,
    methods: Sequence[str | Method] = (),
    seeds: int = 10,
    *,
    first_seed: int = 0,
    out: str | Path | None = None,
    jobs: int | Executor | Engine = 1,
    grid: int = GRID_SIDE,
    keep_trials: bool = False,
    progress: Told | None = None,
) -> Comparison:
    """Run methods on the same seeds of a study, and hold each against the plant's true optimum.

    Each finished run is kept at once: a call that was stopped or killed goes on where it was,
    and a later call with more seeds or methods adds to the tables.

    Parameters
    ----------
    study : str or Path
        Study file whose plant is an FMU, or whose truth `[compare]` names; its `seed` and
        `method` are not looked at. Its budget holds for every method.
    methods : sequence of str or Method
        Names, `NAME:N` for another number of seeds, or methods of your own; none means all.
    seeds : int
        Seeds of each method.
    first_seed : int
        The first of them.
    out : str or Path, optional
        Folder; `STUDY.compare` beside the study file unless given.
    jobs : int, Executor or Engine
        Processes of this machine; with more than one, a script must guard its start by
        `if __name__ == "__main__":`. Or what makes the runs instead: dask's
        `Client.get_executor()`, `mpi4py.futures.MPIPoolExecutor()`, any other of
        `concurrent.futures`. Its workers need the same gmfbo, and no files in common with this
        process.
    grid : int
        Points along a side of the grid of gains that gives the true optimum.
    keep_trials : bool
        Keep all trials of all runs too, each run a packed study in `trials/`.
    progress : callable, optional
        Told in a line of each finished run.

    Raises
    ------
    InputError
        A method is unknown, a number is too small, nothing tells the plant's truth, or the folder
        is of another study.
    SimulationError
        The executor broke; what is finished is kept.
    """
    settings = Settings(methods, seeds, first_seed, jobs, grid, keep_trials, progress)
    return settings.compare(study, out)


def campaign(
    studies: Sequence[str | Path],
    methods: Sequence[str | Method] = (),
    seeds: int = 10,
    *,
    vary: Mapping[str, Sequence[Any]] | None = None,
    out: str | Path,
    first_seed: int = 0,
    jobs: int | Executor | Engine = 1,
    grid: int = GRID_SIDE,
    keep_trials: bool = False,
    progress: Told | None = None,
) -> list[Comparison]:
    """Compare methods on several studies, and on variants of them, with all workers busy.

    What `compare` does for one study; the runs of all of them are handed out together.

    Parameters
    ----------
    studies : sequence of str or Path
        Study files.
    methods : sequence of str or Method
        As of `compare`.
    seeds : int
        Seeds of each method.
    vary : mapping of str to sequence, optional
        Key of the study file, written as in TOML (`is2.parameters."map.noise"`), and the values
        it takes; of several keys, all combinations.
    out : str or Path
        Folder; each study gets `NAME.compare` in it.
    first_seed, jobs, grid, keep_trials, progress
        As of `compare`.

    Returns
    -------
    list of Comparison
        One for each study and variant.

    Raises
    ------
    InputError
        As of `compare`; or two studies bear the same name, or a variant is none.
    SimulationError
        The executor broke; what is finished is kept.
    """
    settings = Settings(methods, seeds, first_seed, jobs, grid, keep_trials, progress)
    return settings.campaign(studies, vary or {}, out)


@dataclass(frozen=True, eq=False)
class Settings:
    """Settings of every study of a comparison or campaign.

    Attributes
    ----------
    methods, seeds, first_seed, jobs, grid, keep_trials, progress
        As of `compare`.
    """

    methods: Sequence[str | Method]
    seeds: int
    first_seed: int
    jobs: int | Executor | Engine
    grid: int
    keep_trials: bool
    progress: Told | None

    def compare(self, study: str | Path, out: str | Path | None) -> Comparison:
        """Do what the function `compare` does."""
        path = Path(study)
        wanted = self._wanted()
        folders = [(Study.read(path), Path(out) if out else path.with_suffix(".compare"))]
        (comparison,) = self._compare_all(folders, wanted, self._command([path], {}, out, wanted))
        return comparison

    def campaign(
        self, studies: Sequence[str | Path], vary: Mapping[str, Sequence[Any]], out: str | Path
    ) -> list[Comparison]:
        """Do what the function `campaign` does."""
        paths = [Path(study) for study in studies]
        _check(studies=(len(paths), 1))
        wanted = self._wanted()
        given = [one for path in paths for one in variants(Study.read(path), vary)]
        folders = [(one, Path(out) / f"{one.file.name}.compare") for one in given]
        names = [folder.name for _, folder in folders]
        if len(set(names)) < len(names):
            raise InputError(
                f"studies: expected a name of its own for each, got {', '.join(names)}"
            )
        return self._compare_all(folders, wanted, self._command(paths, vary, out, wanted))

    def _wanted(self) -> Wanted:
        _check(seeds=(self.seeds, 1), first_seed=(self.first_seed, 0), grid=(self.grid, 3))
        methods = _methods(self.methods, self.seeds)
        return Wanted(methods, self.first_seed, self.grid, self.keep_trials)

    def _compare_all(
        self, folders: Sequence[tuple[Study, Path]], wanted: Wanted, command: str
    ) -> list[Comparison]:
        told, engine = self.progress or (lambda line: None), _engine(self.jobs)
        with ExitStack() as held:
            held.enter_context(closing(engine))
            planned = []
            for study, path in folders:
                folder = ComparisonFolder(path)
                held.enter_context(folder.writing())
                planned.append(PlannedComparison.begin(study, folder, wanted))
            commands = [one.folder.log_command(command) for one in planned]
            # A study is judged by its plant over the box, so that comes first.
            _run(planned, PlannedComparison.truths, engine, told)
            _run(planned, PlannedComparison.runs, engine, told)
            return [
                Comparison(
                    one.folder.path,
                    one.tables([f"$ {line}" for line in lines]),
                    tuple(one.outcomes),
                    one.failed,
                )
                for one, lines in zip(planned, commands, strict=True)
            ]

    def _command(
        self,
        studies: Sequence[Path],
        vary: Mapping[str, Sequence[Any]],
        out: str | Path | None,
        wanted: Wanted,
    ) -> str:
        """The command that makes these runs; what does not change them is left out."""
        named = ",".join(
            m.name if count == self.seeds else f"{m.name}:{count}" for m, count in wanted.methods
        )
        parts = ["gmfbo", "compare", *(path.as_posix() for path in studies)]
        for key, values in vary.items():
            parts += ["--vary", variation_text(key, values)]
        parts += ["--seeds", str(self.seeds), "--methods", named]
        if self.first_seed:
            parts += ["--first-seed", str(self.first_seed)]
        if self.grid != GRID_SIDE:
            parts += ["--grid", str(self.grid)]
        if out is not None:
            parts += ["--out", Path(out).as_posix()]
        return shlex.join(parts)


def _run(
    planned: Sequence[PlannedComparison],
    units_of: Callable[[PlannedComparison], list[Unit]],
    engine: Engine,
    told: Told,
) -> None:
    homes = {unit: one for one in planned for unit in units_of(one)}
    contents = {key: content for one in planned for key, content in one.gathered.contents.items()}
    done = 0

    def finished(unit: Unit, came: Made | Failed) -> None:
        nonlocal done
        done += 1
        one = homes[unit]
        study = f"{one.name}: " if len(planned) > 1 else ""
        told(f"{done} of {len(homes)}: {study}{one.take(unit, came)}")

    Dispatch(engine, contents, finished).run(homes)


def _engine(jobs: int | Executor | Engine) -> Engine:
    if isinstance(jobs, Executor):
        return OnExecutor(jobs)
    if not isinstance(jobs, int):
        return jobs
    _check(jobs=(jobs, 1))
    return InProcess() if jobs == 1 else Processes(jobs)


def _check(**numbers: tuple[int, int]) -> None:
    for name, (value, least) in numbers.items():
        if value < least:
            raise InputError(f"{name.replace('_', '-')}: expected at least {least}, got {value}")


def _methods(methods: Sequence[str | Method], seeds: int) -> tuple[tuple[Method, int], ...]:
    """Each method with its number of seeds; all methods where none is named."""
    wanted: list[tuple[Method, int]] = []
    for method in methods or list(METHODS):
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
    return tuple(wanted)
