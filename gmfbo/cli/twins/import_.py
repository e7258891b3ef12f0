"""`gmfbo import`: an SSP package as a twin."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.completion import paths_ending
from gmfbo.cli.manual import Manual

MANUAL = Manual(
    files={
        "DIR/NAME.toml": "the twin file; NAME is the system's, and it must not be there yet",
        "DIR/": "the FMUs, as they lie in the package",
    },
    examples={"Unpack a drive:": "gmfbo import drive.ssp --out drive"},
    see_also=("gmfbo inspect", "gmfbo simulate", "notebooks/docs/vendor_fmu.md"),
)


def import_(
    package: Annotated[
        Path,
        typer.Argument(
            metavar="PACKAGE", help="SSP 1.0 package (.ssp).", autocompletion=paths_ending(".ssp")
        ),
    ],
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for the FMUs and the twin file.")
    ],
) -> None:
    """Write the FMUs of an SSP package, and a twin file for them.

    The twin file joins them as the package says. None of their code runs.
    """
    from gmfbo.sources.inspection.ssp_import import import_ssp

    made = import_ssp(package, out)
    counts = {"FMU": made.fmus, "wire": made.wires, "input": made.inputs, "output": made.outputs}
    told = ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for what, count in counts.items())
    typer.echo(f"{told} -> {made.twin}")
