"""`gmfbo compare`: tuning methods on the same seeds, as tables and figures."""

from __future__ import annotations

import os
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.console import console


def compare(
    study: Annotated[
        list[Path],
        typer.Argument(
            help="Study files (.toml); or the folder of a comparison, to draw it again."
        ),
    ],
    methods: Annotated[
        str, typer.Option(help="Names with commas; NAME:N for N seeds. All unless given.")
    ] = "",
    seeds: Annotated[int, typer.Option(help="Seeds of each method.")] = 10,
    first_seed: Annotated[int, typer.Option(help="The first of them.")] = 0,
    vary: Annotated[
        list[str],
        typer.Option(
            help="Key of the study file and its values, in TOML: 'budget.initial_is1 = [1, 2]'. "
            "May be repeated, for all combinations.",
        ),
    ] = [],  # noqa: B006 - typer's way to say that none is needed
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder; STUDY.compare beside the study file unless given. Of several studies or "
            "variants: the folder that gets a NAME.compare of each."
        ),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="Processes; one a processor unless given.")
    ] = None,
    executor: Annotated[
        str | None,
        typer.Option(help="Where the runs are made instead: dask:ADDRESS of a scheduler, or mpi."),
    ] = None,
    keep_trials: Annotated[
        bool,
        typer.Option("--keep-trials", help="Keep all trials of each run too, as trials/RUN.h5."),
    ] = False,
    grid: Annotated[
        int, typer.Option(help="Points along a side of the grid that gives the true optimum.")
    ] = 41,
    figures: Annotated[
        Path | None, typer.Option(help="Folder to draw the figures into (SVG, PDF, PNG).")
    ] = None,
) -> None:
    """Compare tuning methods on the same seeds of a study, against the true optimum.

    Each finished run is kept: repeat the command to go on after a stop, or with more seeds.
    """
    from gmfbo.errors import InputError, SimulationError
    from gmfbo.studies.campaign import campaign
    from gmfbo.studies.campaign import compare as compare_methods
    from gmfbo.studies.cluster import open_executor
    from gmfbo.studies.comparison import Comparison
    from gmfbo.studies.variants import parse_variation

    several = len(study) > 1 or bool(vary)
    if several and figures is not None:
        raise InputError("figures: expected one study; draw with 'gmfbo compare NAME.compare'")
    if study[0].is_dir():
        results = [Comparison.read(study[0])]
    else:
        named = [name for name in methods.split(",") if name.strip()]
        processes = (os.cpu_count() or 1) if jobs is None else jobs
        with open_executor(executor) if executor else nullcontext(processes) as made_by:
            if several:
                if out is None:
                    raise InputError(
                        "out: expected a folder for several studies or variants; give --out"
                    )
                varied = dict(map(parse_variation, vary))
                results = campaign(
                    study,
                    named,
                    seeds,
                    vary=varied,
                    out=out,
                    first_seed=first_seed,
                    jobs=made_by,
                    grid=grid,
                    keep_trials=keep_trials,
                    progress=_say,
                )
            else:
                one = compare_methods(
                    study[0],
                    named,
                    seeds,
                    first_seed=first_seed,
                    out=out,
                    jobs=made_by,
                    grid=grid,
                    keep_trials=keep_trials,
                    progress=_say,
                )
                results = [one]
        console.print()
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
