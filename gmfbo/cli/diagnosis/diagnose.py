"""`gmfbo diagnose`: find the physics that the twin lacks, with progress."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gmfbo.cli.arguments import Jobs, Recordings, Seed, TwinFile
from gmfbo.cli.browser import show_page
from gmfbo.cli.completion import effects
from gmfbo.cli.console import console
from gmfbo.cli.manual import Manual
from gmfbo.errors import InputError

if TYPE_CHECKING:
    from gmfbo.diagnosis import Diagnosis


MANUAL = Manual(
    files={
        "DIR/diagnosis.json": "all of it as numbers, SI",
        "DIR/report.html": "a page with the curves, without network",
        "DIR/augmented.fmu": "the twin with the physics in it, unless withheld, for any FMI tool",
        "DIR/augmented.toml": "its twin file",
        "DIR/next.csv": "the reference to play next, where rivals remain",
    },
    examples={
        "What four recordings say:": "gmfbo diagnose axis.toml run*.csv --out found",
        "And its page at the end:": "gmfbo diagnose axis.toml run*.csv --out found --open",
        "What the real runs of a study say:": ("gmfbo diagnose axis.toml axis.study --out found"),
        "With two of them outside every choice:": (
            "gmfbo diagnose axis.toml 1.csv 2.csv --validate 3.csv 4.csv --out found"
        ),
        "Backlash cannot be there:": (
            "gmfbo diagnose axis.toml run*.csv --out found --exclude backlash"
        ),
        "A ripple is known to be there:": (
            "gmfbo diagnose axis.toml run*.csv --out found --assume torque_ripple"
        ),
    },
    exits={
        0: "done, whatever the verdict",
        2: "bad input, in one line; also a recording of opposite sign, in another unit, or of "
        "another axis",
    },
    see_also=(
        "gmfbo check",
        "gmfbo experiment",
        "gmfbo compensate",
        "notebooks/docs/diagnosis.md",
    ),
)


def diagnose(
    twin: TwinFile,
    recordings: Recordings,
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder to write; made if it is not there.")
    ],
    validate: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="REC...", help="Recordings to hold out; chosen from the others without it."
        ),
    ] = None,
    assume: Annotated[
        list[str] | None,
        typer.Option(
            metavar="EFFECT",
            help="Effect to take as present; may be repeated.",
            autocompletion=effects,
        ),
    ] = None,
    exclude: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Effect never to name, or parameter to hold (pattern too); may be repeated.",
            autocompletion=effects,
        ),
    ] = None,
    seed: Seed = 0,
    jobs: Jobs = None,
    open_: Annotated[
        bool, typer.Option("--open", help="Open DIR/report.html in the browser at the end.")
    ] = False,
) -> None:
    """Name the physics that the twin lacks, and model it.

    Refits what is known only roughly, compares what could be missing, names what recordings
    outside the fit do not contradict, and gives the error on unseen recordings before and after.
    Parameters are printed in SI with 95 % intervals.
    """
    from gmfbo.tuning.study.real_run_files import with_runs_of_studies

    _check_effects(twin, assume or [], exclude or [])
    _check_folder(out)

    diagnose_and_show(
        twin,
        with_runs_of_studies(recordings),
        out,
        validate=with_runs_of_studies(validate or []) or None,
        assume=tuple(assume or ()),
        exclude=tuple(exclude or ()),
        seed=seed,
        jobs=jobs,
    )
    if open_:
        show_page(out / "report.html")


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
    """
    from gmfbo.cli.diagnosis.diagnosis_display import DiagnosisDisplay
    from gmfbo.cli.diagnosis.diagnosis_screen import screenful
    from gmfbo.diagnosis import diagnose as run_diagnosis

    with DiagnosisDisplay(console, lines=True) as display:
        diagnosis = run_diagnosis(twin, recordings, progress=display.show, **options)
    written = diagnosis.save(out)
    for line in screenful(with_notes_of_saving(diagnosis, out), written):
        typer.echo(line)
    return diagnosis


def with_notes_of_saving(diagnosis: Diagnosis, out: Path) -> Diagnosis:
    """Put notes of saving first, which tell whether the twin can be exported."""
    noted = [note for note in type(diagnosis).from_json(out).notes if note not in diagnosis.notes]
    return replace(diagnosis, notes=(*noted, *diagnosis.notes))


def _check_effects(twin: Path, assume: Sequence[str], exclude: Sequence[str]) -> None:
    from gmfbo.physics import CATALOGUE

    if any(name not in CATALOGUE for name in (*assume, *exclude)):
        from gmfbo.diagnosis.screening.exclusion import check_assumed, excluded
        from gmfbo.sources.twin.twin import FmuTwin

        with FmuTwin(twin) as opened:
            check_assumed(opened.binding, assume)
            excluded(opened.binding, exclude)
    both = sorted(set(assume) & set(exclude))
    if both:
        raise InputError(f"'{both[0]}' is assumed and excluded; leave one of the two out")


def _check_folder(out: Path) -> None:
    """Raise for a folder that cannot be made, before the work instead of after it."""
    from gmfbo.files.durable import cause

    if out.exists() and not out.is_dir():
        raise InputError(f"--out: expected a folder, but '{out}' is a file; give another name")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--out: cannot make '{out}': {cause(error)}") from None
