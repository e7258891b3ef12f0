"""Gather all files that a study needs, so that it can run on another machine."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import tomli_w

from gmfbo.errors import StudyFileError
from gmfbo.sources.twin_file.twin_file import twin_files
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study_file.study_sections import StudyFile


@dataclass(frozen=True, eq=False)
class StudyFiles:
    """A study and the files that it names, by path under one root.

    Attributes
    ----------
    file : StudyFile
        The study file; its paths begin at `origin`.
    origin : str
        Folder of the study file, relative to the root, with slashes.
    hashes : mapping of str to str
        Path relative to the root, with slashes, = SHA-256 of the content.
    """

    file: StudyFile
    origin: str
    hashes: Mapping[str, str]

    def study(self, root: Path, location: Path) -> Study:
        """The study, with its files under a root.

        Parameters
        ----------
        root : Path
            Folder that holds the files.
        location : Path
            The study's own folder; need not exist.
        """
        stated = self.file.model_dump(
            mode="json", by_alias=True, exclude_unset=True, exclude_none=True
        )
        return Study(self.file, tomli_w.dumps(stated), root / self.origin, location)


@dataclass(frozen=True, eq=False)
class Gathered:
    """Files of a study with their contents.

    Attributes
    ----------
    files : StudyFiles
        Paths and hashes.
    contents : dict of str to bytes
        Each content by its hash.
    """

    files: StudyFiles
    contents: dict[str, bytes]


def gather(study: Study) -> Gathered:
    """Find and read all files that a study names, those in the words of a command included.

    Raises
    ------
    StudyFileError
        A file cannot be read.
    """
    origin = study.origin.resolve()
    file, paths = study.file, set[Path]()
    # Links are followed, so that relative paths between the files stay valid.
    is2 = file.is2.model_copy(update={"twin": _resolved(origin, file.is2.twin)})
    paths.update(twin_files(origin / is2.twin))
    is1 = file.is1
    if is1.twin is not None:
        twin = _resolved(origin, is1.twin)
        is1 = is1.model_copy(update={"twin": twin})
        paths.update(twin_files(origin / twin))
    file = file.model_copy(update={"is1": is1, "is2": is2})
    paths.update(origin / section.file for section in file.references if section.file)
    paths.update(plant_files(study))
    if file.compare.truth is not None:
        paths.add(origin / file.compare.truth)
    if file.objective.metrics is not None:
        paths.add(origin / file.objective.metrics.rpartition(":")[0])
    named = sorted(Path(os.path.normpath(path)) for path in paths)
    root = Path(os.path.commonpath([origin, *(path.parent for path in named)]))
    hashes, contents = dict[str, str](), dict[str, bytes]()
    for path in named:
        content = _content(path)
        digest = hashlib.sha256(content).hexdigest()
        hashes[path.relative_to(root).as_posix()] = digest
        contents[digest] = content
    return Gathered(StudyFiles(file, origin.relative_to(root).as_posix(), hashes), contents)


def plant_files(study: Study) -> list[Path]:
    """Files that make a plant which is no FMU: of its function, and those in its command.

    Parameters
    ----------
    study : Study
        A word of the command is a file if it is the path of one, relative to the study's folder.
    """
    origin, is1 = study.origin.resolve(), study.file.is1
    words = [word for word in is1.command or () if not Path(word).is_absolute()]
    found = [origin / word for word in words if (origin / word).is_file()]
    if is1.function is not None:
        found.append(origin / is1.function.rpartition(":")[0])
    return found


def _resolved(origin: Path, path: str) -> str:
    return PurePosixPath(os.path.relpath((origin / path).resolve(), origin)).as_posix()


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise StudyFileError(
            f"'{path}' cannot be read ({error.strerror or error}); the study needs it"
        ) from None


def seeds_apart(study: Study) -> bool:
    """Whether each seed has another plant."""
    plant = study.file.is1
    changed = plant.change.parameters if plant.change else {}
    return plant.hidden is not None or "seed" in [*plant.parameters.values(), *changed.values()]
