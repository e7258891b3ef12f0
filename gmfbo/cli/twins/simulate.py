"""`gmfbo simulate`: one trajectory of a twin, compared with a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import TwinFile
from gmfbo.cli.console import parse_words
from gmfbo.cli.manual import Manual
from gmfbo.errors import GmfboError, InputError, SimulationError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gmfbo.recordings import Recording, Trajectory
    from gmfbo.sources.twin.twin import FmuTwin

_PAGES = (".html", ".htm")

MANUAL = Manual(
    files={
        "FILE": "time [s] and the twin's signals in SI, parameters in force above the header; or "
        "a page with recorded, simulated and what is left, for each signal"
    },
    examples={
        "The response to a unit step with another gain:": (
            "gmfbo simulate axis.toml --set ctl.Kp=120 --out step.csv"
        ),
        "Against a recording:": "gmfbo simulate axis.toml --reference run1.csv --out sim.csv",
        "As a picture; of an augmented twin beside the twin that it came from:": (
            "gmfbo simulate found/augmented.toml --reference run1.csv --out run1.html"
        ),
    },
    exits={3: "the FMU failed; the rows before that are in FILE"},
    see_also=("gmfbo inspect", "gmfbo diagnose", "notebooks/docs/vendor_fmu.md"),
)


def simulate(
    twin: TwinFile,
    out: Annotated[
        Path,
        typer.Option(metavar="FILE", help="To write: trajectory (.csv, .h5) or picture (.html)."),
    ],
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

    _check_ending(out, reference)
    with FmuTwin(twin) as source:
        recorded = Recording.read(reference, source) if reference else _unit_step(source)
        followed, notes = unwrapped(recorded, source) if reference else (recorded, ())
        given = parse_words(set_ or [], source.binding.variables)
        trajectory = source.run({}, followed, parameters=given)
        remarks: tuple[str, ...] = ()
        if reference:
            remarks = (*_doubts(source, followed, trajectory), *recorded.notes, *notes)
        if out.suffix.lower() in _PAGES and reference:
            remarks += _write_page(source, reference, followed, trajectory, given, remarks, out)
        else:
            write_recording(trajectory, out)
        rows = "1 row" if len(trajectory) == 1 else f"{len(trajectory)} rows"
        typer.echo(f"{source.name}: {rows}, {trajectory.duration:g} s -> {out}")
        if trajectory.status != "ok":
            raise SimulationError(f"{trajectory.message}; the rows before it are in {out}")
        if reference:
            for line in remarks:
                typer.echo(f"! {line}")
            _print_fit(source, trajectory, followed)


def _check_ending(out: Path, reference: Path | None) -> None:
    ending = out.suffix.lower()
    if ending not in (".csv", ".h5", *_PAGES):
        raise InputError(f"--out: expected a file ending in .csv, .h5 or .html, got '{out}'")
    if ending in _PAGES and reference is None:
        raise InputError(
            f"--out {out}: a picture needs a recording beside the twin, got none; give "
            "--reference REC, or write .csv"
        )


def _write_page(
    source: FmuTwin,
    reference: Path,
    followed: Recording,
    run: Trajectory,
    given: Mapping[str, float | str],
    remarks: tuple[str, ...],
    out: Path,
) -> tuple[str, ...]:
    """Write the picture; further remarks, where the twin's origin is not drawn."""
    from gmfbo.files.durable import cause, write_whole
    from gmfbo.reports.simulation.page import Simulated, simulation_page

    compared = tuple(name for name in source.file.outputs if name in followed.signals)
    if not compared:
        raise InputError(
            f"--out {out}: {reference} holds none of the twin's outputs "
            f"({', '.join(source.file.outputs)}), so there is nothing to draw; name its columns "
            "('gmfbo columns'), or write .csv"
        )
    name, nominal, more = _origin_run(source, reference, given)
    simulated = Simulated(
        twin=source.name,
        recorded=followed,
        run=run,
        compared=compared,
        warmup=source.file.warmup or 0.0,
        nominal=nominal,
        nominal_name=name,
        remarks=(*remarks, *more),
        settings=given,
    )
    try:
        write_whole(out, simulation_page(simulated).encode("utf-8"))
    except OSError as error:
        raise InputError(f"--out: cannot write '{out}': {cause(error)}") from None
    return more


def _origin_run(
    source: FmuTwin, reference: Path, given: Mapping[str, float | str]
) -> tuple[str, Trajectory | None, tuple[str, ...]]:
    """Name and run of the twin from which this one was made, or why it is not drawn."""
    from gmfbo.recordings import Recording
    from gmfbo.sources.recorded.wrapped_angle import unwrapped
    from gmfbo.sources.twin.twin import FmuTwin

    if source.file.origin is None:
        return "", None, ()
    path = source.path.parent / source.file.origin
    if not path.is_file():
        return "", None, (f"origin = '{source.file.origin}' is not there; the twin is drawn alone",)
    try:
        with FmuTwin(path) as twin:
            followed, _ = unwrapped(Recording.read(reference, twin), twin)
            shared = {name: v for name, v in given.items() if name in twin.binding.variables}
            run = twin.run({}, followed, parameters=shared)
            missing = [s for s in source.file.outputs if s not in twin.file.outputs]
            if missing:
                raise InputError(f"it has no output '{missing[0]}'")
            return twin.name, run, ()
    except GmfboError as error:
        return "", None, (f"its origin {path.name} is not drawn: {error}",)


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
    from gmfbo.sources.recorded.still_signals import still_lines

    if not recorded.signals.keys() - source.file.inputs.keys():
        return []  # a reference alone: there is nothing to compare
    missing = missing_signals(source, [recorded])
    lines = [
        f"{m.recording}: {m.what}; {m.signal} is not compared, unless 'gmfbo columns' maps it"
        for m in missing
    ]
    lines += still_lines(source, recorded)
    lines += [
        f'[initial] {name} = "fit": a diagnosis fits it, this run begins at the FMU\'s value'
        for name in source.file.fitted_starts
    ]
    return lines + list(filter(None, [contradiction(source, recorded, run)]))


def _print_fit(source: FmuTwin, trajectory: Trajectory, recorded: Recording) -> None:
    import numpy as np

    from gmfbo.errors import RecordingError
    from gmfbo.objective.fit import nrmse

    compared = [
        name
        for name in source.file.outputs
        if name in recorded.signals and np.isfinite(recorded.signals[name]).any()
    ]
    if not compared:
        typer.echo("the recording holds none of the twin's outputs; nothing to compare")
        return
    typer.echo("signal                    NRMSE (RMS error over range)")
    faults = []
    for name in compared:
        try:
            share = nrmse(trajectory, recorded, name, warmup=source.file.warmup or 0.0)
        except RecordingError as error:
            faults.append(error)
            typer.echo(f"{name:<24}  -")
        else:
            typer.echo(f"{name:<24}  {100.0 * share:.4g} %")
    for fault in faults:
        if len(faults) == len(compared):
            raise fault
        typer.echo(f"! {fault}")
