"""`gmfbo repair`: a damaged study becomes one that can be read and resumed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def repair(
    study: Annotated[
        Path, typer.Argument(help="Study folder (NAME.study), or a packed study (.h5).")
    ],
) -> None:
    """Rebuild the index of a study, say what is damaged, and save what can be saved.

    Damaged files of a folder are moved to its folder 'damaged', never deleted. Of a damaged packed
    study the whole trials become a study folder beside it.
    """
    from gmfbo.recordings.repair import repair_folder
    from gmfbo.recordings.repair_packed import repair_packed

    report = repair_packed(study) if study.is_file() else repair_folder(study)
    for line in report.lines:
        typer.echo(line)
    counts = f"{len(report.whole)} trials whole"
    if report.mended:
        counts += f", {len(report.mended)} mended"
    if report.lost:
        counts += f", {len(report.lost)} lost ({', '.join(map(str, report.lost))})"
    typer.echo(f"{report.location}: {counts}" + ("" if report.lines else "; nothing is damaged"))
