"""`gmfbo compare`: tuning methods on the same seeds, as tables and figures."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.console import console


def compare(
    study: Annotated[
        Path,
        typer.Argument(help="Study file (.toml); or the folder of a comparison, to draw it again."),
    ],
    methods: Annotated[
        str, typer.Option(help="Names with commas; NAME:N for N seeds. All unless given.")
    ] = "",
    seeds: Annotated[int, typer.Option(help="Seeds of each method.")] = 10,
    first_seed: Annotated[int, typer.Option(help="The first of them.")] = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder; STUDY.compare beside the study file unless given.")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="Processes; one a processor unless given.")
    ] = None,
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
    from gmfbo.errors import SimulationError
    from gmfbo.studies.comparison import Comparison
    from gmfbo.studies.comparison import compare as compare_methods

    if study.is_dir():
        result = Comparison.read(study)
    else:
        result = compare_methods(
            study,
            [name for name in methods.split(",") if name.strip()],
            seeds,
            first_seed=first_seed,
            out=out,
            jobs=(os.cpu_count() or 1) if jobs is None else jobs,
            grid=grid,
            progress=lambda line: console.print(line, markup=False),
        )
        console.print()
    console.print(result.text, end="", markup=False)
    if result.outcomes:
        console.print(f"\nkept in {result.folder}", markup=False)
    if figures is not None:
        for path in result.draw(figures):
            console.print(f"drawn   {path}", markup=False)
    if result.failed:
        label, reason = next(iter(result.failed.items()))
        raise SimulationError(
            f"{len(result.failed)} runs failed, the first {label}: {reason}; the others are kept, "
            "and the same command tries again"
        )
