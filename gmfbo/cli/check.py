"""`gmfbo check`: what is wrong with recordings and what they can show, before any diagnosis."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.console import console
from gmfbo.errors import InputError


def check(
    twin: Annotated[Path, typer.Argument(help="Twin file (.toml).")],
    recordings: Annotated[
        list[Path], typer.Argument(metavar="REC...", help="Recordings of the real axis.")
    ],
    json: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write all numbers to this file.")
    ] = None,
    every: Annotated[bool, typer.Option("--all", help="Show all findings and effects.")] = False,
    seed: Annotated[int, typer.Option(help="Seed of the noise sent through the loop.")] = 0,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Processes that simulate; one a core without it.")
    ] = None,
) -> None:
    """Look at recordings before a diagnosis: faults of logging, and what they can show.

    Takes seconds, fits nothing, and ends with status 0 also where something is wrong.
    """
    _check_file(json)

    from gmfbo.cli.diagnosis_display import DiagnosisDisplay
    from gmfbo.diagnosis import check as run_check
    from gmfbo.diagnosis.check_text import check_lines

    with DiagnosisDisplay(console) as display:
        seen = run_check(twin, recordings, seed=seed, progress=display.show, jobs=jobs)
    for line in check_lines(seen, every=every):
        typer.echo(line)
    if json is not None:
        _write(json, seen.to_json())
        typer.echo(f"written: {json}")


def _check_file(json: Path | None) -> None:
    """Refuse a file that cannot be written before the work, not after it."""
    if json is None:
        return
    if json.is_dir():
        raise InputError(f"--json: expected a file, but '{json}' is a folder; give a file name")
    if not json.parent.is_dir():
        raise InputError(f"--json: there is no folder '{json.parent}'; create it first")


def _write(path: Path, content: str) -> None:
    from gmfbo.recordings.durable import cause, write_whole

    try:
        write_whole(path, content.encode("utf-8"))
    except OSError as error:
        raise InputError(f"--json: cannot write '{path}': {cause(error)}") from None
