"""`gmfbo experiment`: what to play next, and what was observed against what was predicted."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.console import console
from gmfbo.errors import InputError


def experiment(
    twin: Annotated[Path, typer.Argument(help="Twin file (.toml).")],
    limits: Annotated[
        Path | None,
        typer.Option(
            help="Limits of the axis (.toml, SI): position = [low, high], velocity, acceleration, "
            "duration; jerk and torque may be left out."
        ),
    ] = None,
    diagnosis: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Diagnosis whose rivals are to be told apart."),
    ] = None,
    observed: Annotated[
        Path | None,
        typer.Option(metavar="REC", help="Recording to hold the diagnosis's predictions against."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Reference to write for a drive to play, .csv.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of all randomness.")] = 0,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Processes that simulate; one a core without it.")
    ] = None,
) -> None:
    """Write the next reference to play, within limits; or, with --observed, judge what came of it.

    With --diagnosis it is the one on which the rivals of that diagnosis differ most.
    """
    if observed is not None:
        _confirm(twin, diagnosis, observed, limits, out, seed, jobs)
    else:
        _propose(twin, diagnosis, limits, out, seed, jobs)


def _propose(
    twin: Path,
    folder: Path | None,
    limits: Path | None,
    out: Path | None,
    seed: int,
    jobs: int | None,
) -> None:
    if limits is None:
        raise InputError(
            "expected --limits with the limits of the axis, or --observed with a recording; see "
            "'gmfbo experiment --help'"
        )
    if out is None or out.suffix.lower() != ".csv":
        raise InputError(f"--out: expected a file ending in .csv, got '{out or 'nothing'}'")
    if not out.parent.is_dir():
        raise InputError(f"--out: there is no folder '{out.parent}'; create it first")

    from gmfbo.cli.diagnosis_display import DiagnosisDisplay
    from gmfbo.cli.experiment_text import experiment_lines
    from gmfbo.diagnosis import Diagnosis
    from gmfbo.diagnosis.play_limits import PlayLimits
    from gmfbo.diagnosis.proposing import propose_experiment
    from gmfbo.recordings.writer import write_recording
    from gmfbo.sources.twin import FmuTwin

    allowed = PlayLimits.read(limits)
    found = None if folder is None else Diagnosis.from_json(folder)
    with FmuTwin(twin) as source, DiagnosisDisplay(console) as display:
        proposed = propose_experiment(
            source, allowed, found, seed=seed, jobs=jobs, progress=display.show
        )
    write_recording(proposed.recording, out)
    for line in experiment_lines(proposed, str(out)):
        typer.echo(line)


def _confirm(
    twin: Path,
    folder: Path | None,
    observed: Path,
    limits: Path | None,
    out: Path | None,
    seed: int,
    jobs: int | None,
) -> None:
    if folder is None:
        raise InputError("--observed: expected --diagnosis with the folder whose rivals it judges")
    if limits is not None or out is not None:
        raise InputError("--observed: --limits and --out choose another experiment; leave them out")

    from gmfbo.cli.experiment_text import confirmation_lines
    from gmfbo.diagnosis import Diagnosis
    from gmfbo.diagnosis.confirmation import save_confirmation
    from gmfbo.diagnosis.confirming_run import confirm_with
    from gmfbo.recordings import Recording
    from gmfbo.sources.twin import FmuTwin

    found = Diagnosis.from_json(folder)
    home = folder if folder.is_dir() else folder.parent
    with FmuTwin(twin) as source:
        recording = Recording.read(observed, source)
        confirmation = confirm_with(source, found, recording, seed=seed, jobs=jobs)
    written = save_confirmation(confirmation, home)
    for line in confirmation_lines(confirmation, str(written)):
        typer.echo(line)
