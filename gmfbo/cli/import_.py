"""`gmfbo import`: an SSP package as a twin."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def import_(
    package: Annotated[Path, typer.Argument(help="SSP 1.0 package (.ssp).")],
    out: Annotated[Path, typer.Option(help="Folder for the FMUs and the twin file.")],
) -> None:
    """Write the FMUs of an SSP package and a twin file that joins them as it says."""
    from gmfbo.sources.ssp_import import import_ssp

    made = import_ssp(package, out)
    typer.echo(
        f"{made.fmus} FMUs, {made.wires} wires, {made.inputs} inputs, {made.outputs} outputs "
        f"-> {made.twin}"
    )
