"""Inputs that met a fault, each in a folder of its own, copied to where a test may write."""

from __future__ import annotations

import contextlib
import gzip
import io
import json
import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from gmfbo import models_folder
from gmfbo.cli import main

CASES = Path(os.environ.get("GMFBO_CASES", ""))
PLACEHOLDER = "MODELS"
"""Text in twin files and programs of a case that stands for the project's models."""


def needs_case(name: str) -> pytest.MarkDecorator:
    """Skip a test, with the reason, where the folder of its case is not there.

    Parameters
    ----------
    name : str
        Folder within GMFBO_CASES.
    """
    return pytest.mark.skipif(
        "GMFBO_CASES" not in os.environ or not (CASES / name).is_dir(),
        reason=f"needs the folder {name} of inputs that met a fault in $GMFBO_CASES",
    )


def copied(cases: Path, name: str, into: Path) -> Path:
    """Copy a case, and what all cases share, to a folder that a test may write.

    Files that end in `.gz` are unpacked. `MODELS` in twin files and programs becomes the folder of
    the project's models. Files beside the cases, such as `servo.toml`, come to lie beside the copy.

    Parameters
    ----------
    cases : Path
        Folder of all cases.
    name : str
        Of the case.
    into : Path
        Existing folder that gets the copy.
    """
    folder = into / name
    folder.mkdir()
    for source, target in ((cases, into), (cases / name, folder)):
        for file in sorted(path for path in source.iterdir() if path.is_file()):
            _copy(file, target)
    return folder


def _copy(file: Path, target: Path) -> None:
    if file.suffix == ".gz":
        with gzip.open(file) as packed:
            (target / file.stem).write_bytes(packed.read())
    elif file.suffix in (".toml", ".py"):
        text = file.read_text(encoding="utf-8").replace(PLACEHOLDER, models_folder().as_posix())
        (target / file.name).write_text(text, encoding="utf-8")
    else:
        shutil.copyfile(file, target / file.name)


@dataclass(frozen=True)
class Answer:
    """What a command answered.

    Attributes
    ----------
    code : int
        Exit status.
    out, err : str
        Standard output and standard error, each line break and indent as one blank.
    """

    code: int
    out: str
    err: str


@dataclass(frozen=True)
class CaseFolder:
    """A copied case.

    Attributes
    ----------
    path : Path
        Folder with its files, in which commands run.
    """

    path: Path

    def gmfbo(self, command: str) -> Answer:
        """Run a command line of gmfbo in the folder; `*` in it stands for the files it matches."""
        arguments: list[str] = []
        for word in command.split():
            arguments += sorted(p.name for p in self.path.glob(word)) if "*" in word else [word]
        out, err = io.StringIO(), io.StringIO()
        with (
            contextlib.chdir(self.path),
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(err),
        ):
            code = main(arguments)
        return Answer(code, " ".join(out.getvalue().split()), " ".join(err.getvalue().split()))

    def json(self, name: str) -> Any:
        """Content of a JSON file, below the folder."""
        return json.loads((self.path / name).read_text(encoding="utf-8"))
