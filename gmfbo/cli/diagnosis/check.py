"""`gmfbo check`: faults of recordings, and effects that they can show."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.arguments import Jobs, Recordings, Seed, TwinFile
from gmfbo.cli.console import console
from gmfbo.cli.manual import Manual
from gmfbo.errors import InputError

MANUAL = Manual(
    files={"FILE": "of --json: the same as numbers, SI"},
    examples={
        "What is wrong with four recordings:": "gmfbo check axis.toml run*.csv",
        "All of it, and for a script:": "gmfbo check axis.toml run*.csv --all --json seen.json",
    },
    exits={
        0: "done, also where something is wrong with a recording",
        2: "bad input, in one line; also a recording of opposite sign, in another unit, or of "
        "another axis",
    },
    see_also=(
        "gmfbo columns",
        "gmfbo diagnose",
        "notebooks/docs/recordings.md",
    ),
)


def check(
    twin: TwinFile,
    recordings: Recordings,
    json: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write all numbers to this file.")
    ] = None,
    every: Annotated[bool, typer.Option("--all", help="Show all findings and effects.")] = False,
    seed: Seed = 0,
    jobs: Jobs = None,
) -> None:
    """Look at recordings: what is wrong, and what they can show.

    To be used before a diagnosis. Clock, scale, resolution, repeated samples, alignment,
    controller parity; then, for each effect, the smallest size that each recording would have
    shown. Takes seconds, fits nothing.
    """
    _check_file(json)

    from gmfbo.cli.diagnosis.diagnosis_display import DiagnosisDisplay
    from gmfbo.diagnosis import check as run_check
    from gmfbo.diagnosis.checking.text import check_lines
    from gmfbo.tuning.study.real_run_files import with_runs_of_studies

    runs = with_runs_of_studies(recordings)
    with DiagnosisDisplay(console) as display:
        seen = run_check(twin, runs, seed=seed, progress=display.show, jobs=jobs)
    for line in check_lines(seen, every=every):
        typer.echo(line)
    if json is not None:
        _write(json, seen.to_json())
        typer.echo(f"written: {json}")


def _check_file(json: Path | None) -> None:
    """Raise for a file that cannot be written, before the work instead of after it."""
    if json is None:
        return
    if json.is_dir():
        raise InputError(f"--json: expected a file, but '{json}' is a folder; give a file name")
    if not json.parent.is_dir():
        raise InputError(f"--json: there is no folder '{json.parent}'; create it first")


def _write(path: Path, content: str) -> None:
    from gmfbo.files.durable import cause, write_whole

    try:
        write_whole(path, content.encode("utf-8"))
    except OSError as error:
        raise InputError(f"--json: cannot write '{path}': {cause(error)}") from None
