"""`gmfbo simulate`: one trajectory of a twin, held against a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.console import parse_settings
from gmfbo.errors import InputError, SimulationError

if TYPE_CHECKING:
    from gmfbo.recordings import Recording, Trajectory
    from gmfbo.sources.twin import FmuTwin


def simulate(
    twin: Annotated[Path, typer.Argument(help="Twin file (.toml).")],
    out: Annotated[Path, typer.Option(help="Trajectory to write, .csv or .h5.")],
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="FMU parameter for this run, NAME=VALUE.")
    ] = None,
    reference: Annotated[
        Path | None, typer.Option(help="Recording to follow; a unit step without it.")
    ] = None,
) -> None:
    """Simulate a twin once; with a recording, print how far each signal is from it."""
    from gmfbo.recordings import Recording
    from gmfbo.recordings.writer import write_recording
    from gmfbo.sources.twin import FmuTwin

    if out.suffix.lower() not in (".csv", ".h5"):
        raise InputError(f"--out: expected a file ending in .csv or .h5, got '{out}'")
    with FmuTwin(twin) as source:
        followed = Recording.read(reference, source) if reference else _unit_step(source)
        trajectory = source.run({}, followed, parameters=parse_settings(set_ or []))
        write_recording(trajectory, out)
        typer.echo(f"{source.name}: {len(trajectory)} rows, {trajectory.duration:g} s -> {out}")
        if trajectory.status != "ok":
            raise SimulationError(f"{trajectory.message}; the rows before it are in {out}")
        if reference:
            _print_fit(source, trajectory, followed)


def _unit_step(source: FmuTwin) -> Recording:
    from gmfbo.recordings import step_reference

    inputs = list(source.file.inputs)
    signal = "reference" if "reference" in inputs else (inputs or ["reference"])[0]
    unit = source.signal_specs()[signal].unit if inputs else "rad"
    return step_reference(sample_time=source.step, signal=signal, unit=unit)


def _print_fit(source: FmuTwin, trajectory: Trajectory, recorded: Recording) -> None:
    from gmfbo.objective.fit import nrmse

    compared = [name for name in source.file.outputs if name in recorded.signals]
    if not compared:
        typer.echo("the recording holds none of the twin's outputs; nothing to compare")
        return
    typer.echo("signal                    NRMSE (RMS error over range)")
    for name in compared:
        share = nrmse(trajectory, recorded, name, warmup=source.file.warmup or 0.0)
        typer.echo(f"{name:<24}  {100.0 * share:.4g} %")
