"""`gmfbo inspect`: describe an FMU without running it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.completion import paths_ending
from gmfbo.cli.manual import Manual

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gmfbo.sources.inspection.fmu_report import FmuReport
    from gmfbo.sources.inspection.inspection import FmuVariable

MOST_ROWS = 60
"""Most listed variables of a kind; a lookup table may have hundreds."""


MANUAL = Manual(
    examples={
        "What it is, without running it:": "gmfbo inspect vendor.fmu",
        "A twin file to start from:": "gmfbo inspect --twin-file vendor.fmu > vendor.toml",
    },
    exits={0: "done, also where it cannot run here"},
    see_also=(
        "gmfbo init",
        "gmfbo simulate",
        "gmfbo import",
        "notebooks/docs/vendor_fmu.md",
        "notebooks/docs/faults.md",
    ),
)


def inspect(
    fmu: Annotated[
        Path,
        typer.Argument(metavar="FMU", help="FMU file (.fmu).", autocompletion=paths_ending(".fmu")),
    ],
    twin_file: Annotated[
        bool, typer.Option("--twin-file", help="Print a twin file to start from, nothing else.")
    ] = False,
    everything: Annotated[
        bool, typer.Option("--all", help=f"List more than {MOST_ROWS} variables of a kind.")
    ] = False,
    run: Annotated[
        bool, typer.Option("--run", help="Run its code for a few steps; else none of it runs.")
    ] = False,
) -> None:
    """Print what an FMU is: signals, parameters, findings.

    Variables are listed as NAME [unit] = start in [low, high]. It also says what protects you
    from its code on this machine.
    """
    from gmfbo.sources.inspection.inspection import inspect_fmu, starting_twin_file, try_fmu
    from gmfbo.sources.sandbox.enclosure import protection
    from gmfbo.sources.sandbox.policy import Policy

    report = inspect_fmu(fmu)
    protected = protection(Policy.from_environment())
    if twin_file:
        typer.echo(starting_twin_file(report))
        return
    _print_head(report)
    for title, variables in (
        ("inputs", report.inputs),
        ("outputs", report.outputs),
        ("parameters", report.parameters),
    ):
        _print_variables(title, variables, None if everything else MOST_ROWS)
    typer.echo("capabilities")
    for name, value in report.capabilities.items():
        typer.echo(f"  {name} = {str(value).lower()}")
    typer.echo(f"findings: {len(report.findings) or 'none'}")
    for finding in report.findings:
        typer.echo(f"  {finding}")
    typer.echo("protection when it runs" + ("" if run else "; now none of it did, --run tries it"))
    for line in protected:
        typer.echo(f"  {line}")
    if run:
        typer.echo(f"tried: {try_fmu(report)}")


def _print_head(report: FmuReport) -> None:
    typer.echo(f"{report.name}: {report.description}" if report.description else report.name)
    typer.echo(f"FMI {report.fmi_version}, {' and '.join(report.kinds)}")
    if report.generation_tool:
        typer.echo(f"made by {report.generation_tool}")
    typer.echo(f"platforms: {', '.join(report.platforms) or 'none'}")
    typer.echo(f"runs here: no, {report.obstacle}" if report.obstacle else "runs here: yes")
    if report.default_step is not None:
        typer.echo(f"step: {report.default_step:g} s")


def _print_variables(title: str, variables: Sequence[FmuVariable], most: int | None) -> None:
    typer.echo(f"{title}: {len(variables) or 'none'}")
    for variable in variables[:most]:
        unit = f" [{variable.unit}]" if variable.unit else ""
        if variable.shape:
            unit += f" array of {' x '.join(map(str, variable.shape))}, not used"
        start = "" if variable.start is None else f" = {variable.start:g}"
        bounds = (
            ""
            if variable.minimum is None and variable.maximum is None
            else f" in [{_bound(variable.minimum)}, {_bound(variable.maximum)}]"
        )
        words = f"  {variable.description}" if variable.description else ""
        typer.echo(f"  {variable.name}{unit}{start}{bounds}{words}")
    if most is not None and len(variables) > most:
        typer.echo(f"  and {len(variables) - most} more; --all lists them")


def _bound(value: float | None) -> str:
    return "" if value is None else f"{value:g}"
