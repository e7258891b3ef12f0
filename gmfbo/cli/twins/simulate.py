"""`gmfbo simulate`: one trajectory of a twin, compared with a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import TwinFile
from gmfbo.cli.console import parse_words
from gmfbo.cli.manual import Manual
from gmfbo.errors import InputError, SimulationError

if TYPE_CHECKING:
    from gmfbo.recordings import Recording, Trajectory
    from gmfbo.sources.twin.twin import FmuTwin


MANUAL = Manual(
    files={"FILE": "time [s] and the twin's signals in SI; parameters in force above the header"},
    examples={
        "The response to a unit step with another gain:": (
            "gmfbo simulate axis.toml --set ctl.Kp=120 --out step.csv"
        ),
        "Against a recording:": "gmfbo simulate axis.toml --reference run1.csv --out sim.csv",
    },
    exits={3: "the FMU failed; the rows before that are in FILE"},
    see_also=("gmfbo inspect", "gmfbo diagnose", "notebooks/docs/fmus.md"),
)


def simulate(
    twin: TwinFile,
    out: Annotated[Path, typer.Option(metavar="FILE", help="Trajectory to write, .csv or .h5.")],
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="FMU parameter of this run [its unit in the FMU], or text, true, false or an "
            "enumeration's item; may be repeated.",
        ),
    ] = None,
    reference: Annotated[
        Path | None,
        typer.Option(
            metavar="REC",
            help="Recording to follow; a step of 1 rad or m at 0.1 s without it.",
        ),
    ] = None,
) -> None:
    """Simulate a twin once; hold it against a recording.

    With --reference it prints the NRMSE of each signal that the recording also holds: RMS error
    over the range of the recorded signal [%].
    """
    from gmfbo.recordings import Recording
    from gmfbo.recordings.writing.writer import write_recording
    from gmfbo.sources.recorded.wrapped_angle import unwrapped
    from gmfbo.sources.twin.twin import FmuTwin

    if out.suffix.lower() not in (".csv", ".h5"):
        raise InputError(f"--out: expected a file ending in .csv or .h5, got '{out}'")
    with FmuTwin(twin) as source:
        recorded = Recording.read(reference, source) if reference else _unit_step(source)
        followed, notes = unwrapped(recorded, source) if reference else (recorded, ())
        given = parse_words(set_ or [], source.binding.variables)
        trajectory = source.run({}, followed, parameters=given)
        write_recording(trajectory, out)
        typer.echo(f"{source.name}: {len(trajectory)} rows, {trajectory.duration:g} s -> {out}")
        if trajectory.status != "ok":
            raise SimulationError(f"{trajectory.message}; the rows before it are in {out}")
        if reference:
            for line in (*_doubts(source, followed, trajectory), *recorded.notes, *notes):
                typer.echo(f"! {line}")
            _print_fit(source, trajectory, followed)


def _unit_step(source: FmuTwin) -> Recording:
    from gmfbo.recordings import step_reference

    inputs = list(source.file.inputs)
    signal = "reference" if "reference" in inputs else (inputs or ["reference"])[0]
    unit = source.signal_specs()[signal].unit if inputs else "rad"
    return step_reference(sample_time=source.step, signal=signal, unit=unit)


def _doubts(source: FmuTwin, recorded: Recording, run: Trajectory) -> list[str]:
    """Lines on what is not compared, and on a recording that contradicts the twin."""
    from gmfbo.sources.recorded.contradiction import contradiction
    from gmfbo.sources.recorded.missing_signals import missing_signals

    if not recorded.signals.keys() - source.file.inputs.keys():
        return []  # a reference alone: there is nothing to compare
    missing = missing_signals(source, [recorded])
    lines = [
        f"{m.recording}: {m.what}; {m.signal} is not compared, unless 'gmfbo columns' maps it"
        for m in missing
    ]
    return lines + list(filter(None, [contradiction(source, recorded, run)]))


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
