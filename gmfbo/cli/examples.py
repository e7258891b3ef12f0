"""`gmfbo examples`: copy what the documentation's commands work on."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.manual import Manual
from gmfbo.errors import InputError

MODELS = ("servo_axis", "demo_axis")
"""Twin files, with their FMU, that lie in models/ and go beside the recordings."""

PARTS = ("cascade_p_pi", "motor_bench")
"""FMUs in models/ that `p_pi_axis.toml` joins."""

MANUAL = Manual(
    files={
        "DIR/README.md": "what each file is",
        "DIR/vendor/": "a vendor's FMU, with logs of its axis in milliseconds and degrees",
        "DIR/limits.toml": "what that axis may do",
        "DIR/joint.toml": "a tuning study of the same axis",
        "DIR/servo_axis.toml": "a twin, with four recordings run0.csv to run3.csv of its axis",
        "DIR/p_pi_axis.toml": "a twin for an axis without an FMU: a motor under P-PI control",
    },
    examples={"Then cd tour, and type README's commands:": "gmfbo examples tour"},
    see_also=("gmfbo demo", "gmfbo diagnose", "README.md"),
)


def examples(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="New or empty folder for them.")],
) -> None:
    """Copy the documentation's examples into a folder.

    Recordings, twin files, FMUs, limits and a study, small enough to try every command within
    minutes. Nothing that is there already is overwritten.
    """
    sources = [*_files(examples_folder()), *_models()]
    _prepare(folder)
    try:
        for place, source in sources:
            target = folder / place
            target.parent.mkdir(exist_ok=True)
            shutil.copyfile(source, target)
    except OSError as error:
        raise InputError(
            f"cannot write the examples into '{folder}': {error.strerror}; name another folder"
        ) from None
    typer.echo(f"{len(sources)} files -> {folder}; {folder / 'README.md'} says what each is")


def examples_folder() -> Path:
    """Folder of the examples, the same call in a checkout, an editable install and a wheel."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "_examples"
    return installed if installed.is_dir() else package.parent / "notebooks" / "examples"


def _files(folder: Path) -> list[tuple[Path, Path]]:
    """Each file below a folder: its place there, and its path."""
    return [
        (path.relative_to(folder), path) for path in sorted(folder.rglob("*")) if path.is_file()
    ]


def _models() -> list[tuple[Path, Path]]:
    from gmfbo.sources.fmu_file.models import models_folder

    names = [f"{model}.{ending}" for model in MODELS for ending in ("toml", "fmu")]
    names += [f"{part}.fmu" for part in PARTS]
    return [(Path(name), models_folder() / name) for name in names]


def _prepare(folder: Path) -> None:
    """Make the folder, or refuse one that holds anything: a user's own files stay as they are."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        filled = any(folder.iterdir())
    except OSError as error:
        raise InputError(
            f"DIR: expected a folder that can be made, got '{folder}': {error.strerror}; "
            "name another"
        ) from None
    if filled:
        raise InputError(
            f"DIR: expected a new or empty folder, but '{folder}' holds files; name another"
        )
