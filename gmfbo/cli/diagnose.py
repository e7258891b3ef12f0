"""`gmfbo diagnose`: what the twin lacks, shown while it is found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gmfbo.cli.console import console
from gmfbo.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from gmfbo.diagnosis import Diagnosis


def diagnose(
    twin: Annotated[Path, typer.Argument(help="Twin file (.toml).")],
    recordings: Annotated[
        list[Path], typer.Argument(metavar="REC...", help="Recordings of the real axis.")
    ],
    out: Annotated[Path, typer.Option(help="Folder to write; made if it is not there.")],
    validate: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="REC...", help="Recordings to hold out; chosen from the others without it."
        ),
    ] = None,
    assume: Annotated[
        list[str] | None,
        typer.Option(metavar="EFFECT", help="Effect to take as present; may be repeated."),
    ] = None,
    exclude: Annotated[
        list[str] | None,
        typer.Option(metavar="EFFECT", help="Effect never to name; may be repeated."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of all randomness.")] = 0,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Processes that simulate; one a core without it.")
    ] = None,
) -> None:
    """Name the physics that the twin lacks, model it, and show the fit on unseen recordings.

    Writes diagnosis.json, report.html, augmented.fmu and augmented.toml.
    """
    _check_effects(assume or [], exclude or [])
    _check_folder(out)

    diagnose_and_show(
        twin,
        recordings,
        out,
        validate=validate or None,
        assume=tuple(assume or ()),
        exclude=tuple(exclude or ()),
        seed=seed,
        jobs=jobs,
    )


def diagnose_and_show(
    twin: Path, recordings: Sequence[Path], out: Path, **options: Any
) -> Diagnosis:
    """Diagnose with progress on the terminal, write the folder and print one screen.

    Parameters
    ----------
    twin : Path
        Twin file.
    recordings : sequence of Path
        Of the real axis.
    out : Path
        Folder to write.
    **options
        Of `gmfbo.diagnose`.

    Returns
    -------
    Diagnosis
        What was found.
    """
    from gmfbo.cli.diagnosis_display import DiagnosisDisplay
    from gmfbo.cli.diagnosis_screen import screenful
    from gmfbo.diagnosis import diagnose as run_diagnosis

    with DiagnosisDisplay(console) as display:
        diagnosis = run_diagnosis(twin, recordings, progress=display.show, **options)
    written = diagnosis.save(out)
    for line in screenful(with_notes_of_saving(diagnosis, out), written):
        typer.echo(line)
    return diagnosis


def with_notes_of_saving(diagnosis: Diagnosis, out: Path) -> Diagnosis:
    """Add what saving noted, first: it finds out whether the twin can be exported.

    Parameters
    ----------
    diagnosis : Diagnosis
        As it was saved.
    out : Path
        Where.
    """
    noted = [note for note in type(diagnosis).from_json(out).notes if note not in diagnosis.notes]
    return replace(diagnosis, notes=(*noted, *diagnosis.notes))


def _check_effects(assume: Sequence[str], exclude: Sequence[str]) -> None:
    from gmfbo.physics import CATALOGUE

    for option, names in (("--assume", assume), ("--exclude", exclude)):
        for name in names:
            if name not in CATALOGUE:
                raise InputError(
                    f"{option}: expected the name of an effect, got '{name}'"
                    f"{did_you_mean(name, CATALOGUE)}"
                )
    both = sorted(set(assume) & set(exclude))
    if both:
        raise InputError(f"'{both[0]}' is assumed and excluded; leave one of the two out")


def _check_folder(out: Path) -> None:
    """Refuse a folder that cannot be made before the work, not after it."""
    from gmfbo.recordings.durable import cause

    if out.exists() and not out.is_dir():
        raise InputError(f"--out: expected a folder, but '{out}' is a file; give another name")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--out: cannot make '{out}': {cause(error)}") from None
