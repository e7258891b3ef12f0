"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gmfbo.cli.completion import paths_ending


def _not_withheld(twin: Path) -> Path:
    """Refuse the twin of a diagnosis that handed none back, with the reason and the twin to use."""
    told = twin.with_name("diagnosis.json")
    try:
        if twin.name != "augmented.toml" or twin.exists() or not told.is_file():
            return twin
    except OSError:  # what reads the twin says what is wrong with its path
        return twin
    from gmfbo.diagnosis import Diagnosis
    from gmfbo.errors import InputError

    found = Diagnosis.from_json(told)
    if not found.fit.twin_is_withheld:
        return twin
    stated = [one.stated.partition(", line ")[0] for one in found.parameters.values()]
    came = next((f", {name}" for name in stated if name), "")
    raise InputError(
        f"no twin file at '{twin}': the twin as it came meets the unseen recordings better, so "
        f"the diagnosis handed none back; use the one that was diagnosed{came}"
    )


TwinFile = Annotated[
    Path,
    typer.Argument(
        metavar="TWIN",
        help="Twin file (.toml).",
        autocompletion=paths_ending(".toml"),
        callback=_not_withheld,
    ),
]

StudyFile = Annotated[
    Path,
    typer.Argument(
        metavar="STUDY", help="Study file (.toml).", autocompletion=paths_ending(".toml")
    ),
]

LivePage = Annotated[
    Path | None,
    typer.Option(
        "--html",
        metavar="PAGE",
        help="Page (.html) to keep up to date while the study runs; a browser that shows the "
        "file loads it again by itself.",
    ),
]

StudyFolder = Annotated[
    Path,
    typer.Argument(
        metavar="FOLDER",
        help="Study folder (NAME.study), written by 'gmfbo tune'.",
        autocompletion=paths_ending(".study"),
    ),
]

Recordings = Annotated[
    list[Path],
    typer.Argument(
        metavar="REC...",
        help="Recordings of the real axis: .csv, .h5, .mat, .parquet, .mf4 or .tdms; a study "
        "folder stands for its real runs.",
    ),
]

Seed = Annotated[
    int, typer.Option(metavar="N", help="Seed of all randomness: the same seed, the same result.")
]

Jobs = Annotated[
    int | None,
    typer.Option(min=1, metavar="N", help="Processes that simulate; one a core without it."),
]
