"""`gmfbo export`: a study as one file for others."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def export(
    study: Annotated[Path, typer.Argument(help="Study folder (NAME.study).")],
    pack: Annotated[Path, typer.Option(help="HDF5 file to write.")],
) -> None:
    """Pack a study into one self-contained HDF5 file, for others and for MATLAB."""
    from gmfbo.recordings.pack import pack_study

    pack_study(study, pack)
    typer.echo(f"{study} -> {pack} ({pack.stat().st_size / 1e6:.1f} MB)")
