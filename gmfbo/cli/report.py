"""`gmfbo report`: a study or a comparison as one page that needs no network."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.errors import InputError


def report(
    study: Annotated[
        Path,
        typer.Argument(help="Study folder (NAME.study) or packed study (.h5)."),
    ],
    out: Annotated[Path, typer.Option(help="Page to write (.html); an older one is replaced.")],
) -> None:
    """Write a self-contained page of a study; it may still run.

    Gains explored, the way to the best, who was asked, trust in the twin, and the trajectories of
    every run. It opens in any browser, without a network.
    """
    from gmfbo.recordings.durable import cause, write_whole
    from gmfbo.reports.study_page import study_page
    from gmfbo.reports.study_review import StudyReview

    if out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--out: expected a file name that ends in .html, got '{out}'")
    page = study_page(StudyReview.read(study)).encode()
    try:
        write_whole(out, page)
    except OSError as error:
        raise InputError(f"--out: cannot write '{out}': {cause(error)}") from None
    typer.echo(f"{study} -> {out} ({len(page) / 1e6:.1f} MB)")
