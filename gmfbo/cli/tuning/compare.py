"""`gmfbo compare`: tuning methods on the same seeds, as tables and figures."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.completion import methods as complete_methods
from gmfbo.cli.completion import paths_ending
from gmfbo.cli.console import console
from gmfbo.cli.manual import Manual

if TYPE_CHECKING:
    from gmfbo.studies.comparison import Comparison

MANUAL = Manual(
    files={
        "STUDY.compare/": "runs/ with a line a study, truth/ with the grid; table.txt, curves.txt "
        "and landscape.txt, which follow from them; with --keep-trials trials/",
    },
    examples={
        "Two methods, one of them on ten seeds:": (
            "gmfbo compare joint.toml --methods gmfbo:10,bo_ei --seeds 5"
        ),
        "A study with several budgets:": (
            "gmfbo compare joint.toml --vary 'budget.is1_runs = [8, 22]' --out results"
        ),
        "On the workers of a dask scheduler:": (
            "gmfbo compare joint.toml --executor dask:tcp://bench:8786"
        ),
        "Draw what is there again:": "gmfbo compare joint.compare --figures figures",
    },
    exits={3: "some runs failed; the others are kept, and the same command tries again"},
    see_also=("gmfbo methods", "gmfbo report", "notebooks/docs/many_machines.md"),
)


Studies = Annotated[
    list[Path],
    typer.Argument(
        metavar="STUDY...",
        help="Study files (.toml); or the folder of a comparison, to draw it again.",
        autocompletion=paths_ending(".toml", ".compare"),
    ),
]
Methods = Annotated[
    str,
    typer.Option(
        metavar="A,B,...",
        help="Names with commas; NAME:N for N seeds. All without it.",
        autocompletion=complete_methods,
    ),
]
Seeds = Annotated[int, typer.Option(metavar="N", help="Seeds of each method.")]
FirstSeed = Annotated[int, typer.Option(metavar="N", help="The first of them.")]
Vary = Annotated[
    list[str],
    typer.Option(
        metavar="KEY=[A,B]",
        help="Key of the study file and its values, in TOML: 'budget.initial_is1 = [1, 2]'; "
        "may be repeated, for all combinations.",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        help="Folder; STUDY.compare beside the study file without it. Of several studies or "
        "variants: the folder that gets a NAME.compare of each.",
    ),
]
Jobs = Annotated[
    int | None,
    typer.Option(metavar="N", help="Processes, a study each; one a core without it."),
]
Where = Annotated[
    str | None,
    typer.Option(
        metavar="WHERE",
        help="Where the runs are made instead: dask:ADDRESS of a scheduler, or mpi.",
    ),
]
KeepTrials = Annotated[
    bool,
    typer.Option("--keep-trials", help="Keep all trials of each run too, as trials/RUN.h5."),
]
GridSide = Annotated[
    int,
    typer.Option(metavar="N", help="Points along a side of the grid that gives the true optimum."),
]
Figures = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder to draw the figures into (SVG, PDF, PNG)."),
]


def compare(
    study: Studies,
    methods: Methods = "",
    seeds: Seeds = 10,
    first_seed: FirstSeed = 0,
    vary: Vary = [],  # noqa: B006 - typer's way to say that none is needed
    out: Out = None,
    jobs: Jobs = None,
    executor: Where = None,
    keep_trials: KeepTrials = False,
    grid: GridSide = 41,
    figures: Figures = None,
) -> None:
    """Compare tuning methods on the same seeds of a study.

    Each method is held against the true optimum of the plant. An FMU is run over a grid for it;
    for a command or a Python function a table tells it, `[compare] truth = FILE` in the study
    file. Tables count the real runs until a method is within 2 % of the way from the optimum to
    the median. Each finished run is kept: repeat the command to go on after a stop, or with more
    seeds.
    """
    from gmfbo.errors import InputError
    from gmfbo.studies.campaign import Settings
    from gmfbo.studies.cluster import open_executor
    from gmfbo.studies.comparison import Comparison
    from gmfbo.studies.variants import parse_variation

    several = len(study) > 1 or bool(vary)
    if several and figures is not None:
        raise InputError("figures: expected one study; draw with 'gmfbo compare NAME.compare'")
    if study[0].is_dir():
        _tell([Comparison.read(study[0])], figures)
        return
    named = [name for name in methods.split(",") if name.strip()]
    processes = (os.cpu_count() or 1) if jobs is None else jobs
    with open_executor(executor) if executor else nullcontext(processes) as made_by:
        settings = Settings(named, seeds, first_seed, made_by, grid, keep_trials, _say)
        if not several:
            results = [settings.compare(study[0], out)]
        elif out is None:
            raise InputError("out: expected a folder for several studies or variants; give --out")
        else:
            results = settings.campaign(study, dict(map(parse_variation, vary)), out)
    console.print()
    _tell(results, figures)


def _tell(results: Sequence[Comparison], figures: Path | None) -> None:
    """Print the tables and draw the first; then fail if runs did."""
    from gmfbo.errors import SimulationError

    for result in results:
        console.print(result.text, end="", markup=False)
        if result.outcomes:
            console.print(f"\nkept in {result.folder}", markup=False)
    if figures is not None:
        for path in results[0].draw(figures):
            console.print(f"drawn   {path}", markup=False)
    failed = {label: why for result in results for label, why in result.failed.items()}
    if failed:
        label, reason = next(iter(failed.items()))
        raise SimulationError(
            f"{len(failed)} runs failed, the first {label}: {reason}; the others are kept, "
            "and the same command tries again"
        )


def _say(line: str) -> None:
    console.print(line, markup=False)
