"""`gmfbo report`: a study or a comparison as one page that needs no network."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.errors import InputError

TABLE_NAME = "table.txt"  # by which the folder of a comparison is known; studies load torch


def report(
    study: Annotated[
        Path,
        typer.Argument(
            help="Study folder (NAME.study), packed study (.h5), or folder of a comparison."
        ),
    ],
    out: Annotated[Path, typer.Option(help="Page to write (.html); an older one is replaced.")],
) -> None:
    """Write a self-contained page of a study, which may still run, or of a comparison.

    Of a study: gains explored, the way to the best, who was asked, trust in the twin, and the
    trajectories of every run. Of a comparison: means with intervals, and every seed. The page
    opens in any browser, without a network.
    """
    from gmfbo.recordings.durable import cause, write_whole

    if out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--out: expected a file name that ends in .html, got '{out}'")
    page = _page(study).encode()
    try:
        write_whole(out, page)
    except OSError as error:
        raise InputError(f"--out: cannot write '{out}': {cause(error)}") from None
    typer.echo(f"{study} -> {out} ({len(page) / 1e6:.1f} MB)")


def _page(study: Path) -> str:
    if (study / TABLE_NAME).is_file():
        from gmfbo.reports.comparison_page import comparison_page
        from gmfbo.studies.comparison_review import review_comparison

        return comparison_page(review_comparison(study))
    from gmfbo.reports.study_page import study_page
    from gmfbo.reports.study_review import StudyReview

    return study_page(StudyReview.read(study))
