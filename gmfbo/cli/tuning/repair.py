"""`gmfbo repair`: make a damaged study readable and resumable."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.completion import paths_ending
from gmfbo.cli.manual import Manual

MANUAL = Manual(
    files={
        "FOLDER/damaged/": "what was set aside, and what was saved of it",
        "FOLDER/index.h5": "anew",
        "NAME.repaired.study/": "the whole trials of a packed study",
    },
    examples={
        "After a disk has failed:": "gmfbo repair joint.study",
        "And on with it:": "gmfbo tune joint.toml --resume",
    },
    exits={0: "done, also where something is lost; the lines say what"},
    see_also=("gmfbo export", "gmfbo tune", "notebooks/docs/store.md"),
)


def repair(
    study: Annotated[
        Path,
        typer.Argument(
            metavar="STUDY",
            help="Study folder (NAME.study), or a packed study (.h5).",
            autocompletion=paths_ending(".study", ".h5"),
        ),
    ],
) -> None:
    """Mend or save what is damaged in a study; rebuild its index.

    Damaged files of a folder are moved to its folder 'damaged', never deleted. Of a damaged packed
    study the whole trials become a study folder beside it.
    """
    from gmfbo.recordings.repair.repair_folder import repair_folder
    from gmfbo.recordings.repair.repair_packed import repair_packed

    report = repair_packed(study) if study.is_file() else repair_folder(study)
    for line in report.lines:
        typer.echo(line)
    counts = f"{len(report.whole)} trials whole"
    if report.mended:
        counts += f", {len(report.mended)} mended"
    if report.lost:
        counts += f", {len(report.lost)} lost ({', '.join(map(str, report.lost))})"
    typer.echo(f"{report.location}: {counts}" + ("" if report.lines else "; nothing is damaged"))
