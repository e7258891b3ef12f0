"""`gmfbo report`: a study or a comparison as one page that needs no network."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.completion import paths_ending
from gmfbo.cli.manual import Manual
from gmfbo.errors import InputError

TABLE_NAME = "table.txt"  # marks a comparison's folder; importing studies would load torch


MANUAL = Manual(
    files={
        "FILE": "one page with all it needs",
        "DIR/": "of --figures: all figures; needs matplotlib (the extra 'figures')",
    },
    examples={
        "A page:": "gmfbo report joint.study --out joint.html",
        "And figures for a paper:": ("gmfbo report joint.study --out joint.html --figures figures"),
    },
    see_also=("gmfbo watch", "gmfbo compare", "notebooks/docs/reports.md"),
)


def report(
    study: Annotated[
        Path,
        typer.Argument(
            metavar="STUDY",
            help="Study folder (NAME.study), packed study (.h5), or folder of a comparison.",
            autocompletion=paths_ending(".study", ".compare", ".h5"),
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(metavar="FILE", help="Page to write (.html); an older one is replaced."),
    ],
    figures: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder to draw figures for a paper into (PDF, SVG)."),
    ] = None,
) -> None:
    """Write a page of a study, or of a comparison.

    The study may still run. Its page shows the gains explored, the way to the best, who was
    asked, trust in the twin, and the trajectories of every run; that of a comparison means with
    intervals, and every seed. The page opens in any browser, without a network.
    """
    from gmfbo.files.durable import cause, write_whole

    if out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--out: expected a file name that ends in .html, got '{out}'")
    page, drawn = _page(study, figures)
    try:
        write_whole(out, page.encode())
    except OSError as error:
        raise InputError(f"--out: cannot write '{out}': {cause(error)}") from None
    typer.echo(f"{study} -> {out} ({len(page.encode()) / 1e6:.1f} MB)")
    for path in drawn:
        typer.echo(f"drawn   {path}")


def _page(path: Path, figures: Path | None) -> tuple[str, list[Path]]:
    if (path / TABLE_NAME).is_file():
        return _comparison_page(path, figures)
    from gmfbo.reports.study.page import study_page
    from gmfbo.reports.study.review import StudyReview

    review = StudyReview.read(path)
    drawn = []
    if figures is not None:
        from gmfbo.reports.figures.study_figures import draw_study

        drawn = draw_study(review, figures)
    return study_page(review), drawn


def _comparison_page(path: Path, figures: Path | None) -> tuple[str, list[Path]]:
    from gmfbo.reports.comparison.page import comparison_page
    from gmfbo.reports.figures.comparison_figures import draw_comparison
    from gmfbo.studies.comparison_review import review_comparison

    review = review_comparison(path)
    drawn = draw_comparison(review.curves, review.landscape, figures) if figures else []
    return comparison_page(review), drawn
