"""`gmfbo experiment`: propose the next recording, and compare it with predictions."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.arguments import Jobs, Seed, TwinFile
from gmfbo.cli.completion import paths_ending
from gmfbo.cli.console import console
from gmfbo.cli.manual import Manual
from gmfbo.errors import InputError

MANUAL = Manual(
    files={
        "FILE": "of --out: time [s] and reference [rad or m], for a drive to play",
        "DIR/confirmation.json": "of --observed: predicted against observed",
    },
    examples={
        "What to play so that much can be seen:": (
            "gmfbo experiment axis.toml --limits lim.toml --out next.csv"
        ),
        "What settles the rivals of a diagnosis:": (
            "gmfbo experiment axis.toml --limits lim.toml --diagnosis found --out n.csv"
        ),
        "What a recording of it says:": (
            "gmfbo experiment axis.toml --diagnosis found --observed played.csv"
        ),
    },
    see_also=("gmfbo diagnose", "gmfbo compensate", "notebooks/docs/after_a_diagnosis.md"),
)


def experiment(
    twin: TwinFile,
    limits: Annotated[
        Path | None,
        typer.Option(
            metavar="LIMITS",
            help="Limits of the axis (.toml): position = [low, high] [rad or m], velocity, "
            "acceleration, duration [s]; jerk and torque [N.m or N] may be left out.",
            autocompletion=paths_ending(".toml"),
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
        Path | None,
        typer.Option(metavar="FILE", help="Reference to write for a drive to play, .csv."),
    ] = None,
    seed: Seed = 0,
    jobs: Jobs = None,
) -> None:
    """Write the next reference to play, or judge what came of it.

    With --limits and --out it chooses a reference within the limits; with --diagnosis too, the
    one on which the rivals of that diagnosis differ most. With --diagnosis and --observed it
    says which of them a recording supports.
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

    from gmfbo.cli.diagnosis.diagnosis_display import DiagnosisDisplay
    from gmfbo.cli.diagnosis.experiment_text import experiment_lines
    from gmfbo.diagnosis import Diagnosis
    from gmfbo.diagnosis.experiment.play_limits import PlayLimits
    from gmfbo.diagnosis.experiment.within_limits import propose_experiment
    from gmfbo.recordings.writing.writer import write_recording
    from gmfbo.sources.twin.twin import FmuTwin

    allowed = PlayLimits.read(limits)
    found = None if folder is None else Diagnosis.from_json(folder)
    with FmuTwin(twin) as source, DiagnosisDisplay(console, lines=True) as display:
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

    from gmfbo.cli.diagnosis.experiment_text import confirmation_lines
    from gmfbo.diagnosis import Diagnosis
    from gmfbo.diagnosis.experiment.observed import save_confirmation
    from gmfbo.diagnosis.experiment.predicted_against_observed import confirm_with
    from gmfbo.recordings import Recording
    from gmfbo.sources.twin.twin import FmuTwin

    found = Diagnosis.from_json(folder)
    home = folder if folder.is_dir() else folder.parent
    with FmuTwin(twin) as source:
        recording = Recording.read(observed, source)
        confirmation = confirm_with(source, found, recording, seed=seed, jobs=jobs)
    written = save_confirmation(confirmation, home)
    for line in confirmation_lines(confirmation, str(written)):
        typer.echo(line)
