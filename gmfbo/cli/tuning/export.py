"""`gmfbo export`: a study as one file for others."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.arguments import StudyFolder
from gmfbo.cli.manual import Manual

MANUAL = Manual(
    files={"FILE": "/trials/000001 and so on, the study file and the events"},
    examples={"All runs in one file:": "gmfbo export joint.study --pack joint.h5"},
    see_also=("gmfbo report", "gmfbo repair", "notebooks/docs/store.md"),
)


def export(
    study: StudyFolder,
    pack: Annotated[Path, typer.Option(metavar="FILE", help="HDF5 file to write (.h5).")],
) -> None:
    """Pack a study into one HDF5 file, for others and for MATLAB.

    It reads like the folder: `gmfbo report` and `Study.read` take it.
    """
    from gmfbo.recordings.store.pack import pack_study

    pack_study(study, pack)
    typer.echo(f"{study} -> {pack} ({pack.stat().st_size / 1e6:.1f} MB)")
