"""`gmfbo build`: the project's own FMUs from their sources."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.completion import compilers, models
from gmfbo.cli.manual import Manual
from gmfbo.errors import InputError

MANUAL = Manual(
    files={"models/": "the FMUs and libraries, where they differ"},
    examples={
        "After a new effect:": "gmfbo build --only physics",
        "Whether what is committed is what the sources give:": "gmfbo build --check",
    },
    exits={2: "bad input, a source that does not compile, or with --check a file that differs"},
    see_also=("notebooks/docs/fmus.md",),
)


def build(
    only: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MODEL",
            help="Build this model alone; may be repeated.",
            autocompletion=models,
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for the FMUs; models/ without it.")
    ] = None,
    compiler: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="'zig' for all platforms, 'system' for this one.",
            autocompletion=compilers,
        ),
    ] = "zig",
    translate: Annotated[
        bool, typer.Option("--translate", help="Translate the Modelica sources to C first.")
    ] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Rebuild and compare bytes; write nothing.")
    ] = False,
) -> None:
    """Build the project's own FMUs from fmu_build/ into models/.

    For developers, from a checkout: whoever uses gmfbo has them built. The same sources give the
    same bytes.
    """
    checkout = Path(__file__).resolve().parents[3]
    sources = checkout / "fmu_build"
    if not (sources / "build.py").is_file():
        raise InputError(
            "gmfbo build needs the sources in fmu_build/, which an installed package does not "
            "carry; run it from a checkout of the project"
        )
    if compiler not in ("zig", "system"):
        raise InputError(f"--compiler: expected 'zig' or 'system', got '{compiler}'")
    sys.path.insert(0, str(checkout))
    builder = importlib.import_module("fmu_build.build")
    try:
        builder.build_all(
            output or checkout / "models",
            only=tuple(only or ()),
            compiler=compiler,
            translate=translate,
            check=check,
            report=typer.echo,
        )
    except builder.BuildError as error:
        raise InputError(str(error)) from error
