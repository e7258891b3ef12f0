"""A plant measured beforehand at many gains, whose recordings are replayed."""

from __future__ import annotations

import csv
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

import numpy as np

from gmfbo.errors import InputError, RecordingError, StudyFileError
from gmfbo.recordings.columns.signal import SignalReading
from gmfbo.recordings.recording import Recording, read_recording
from gmfbo.sources.plants.failed_run import failed_run

INDEX = "gains.csv"
"""Optional file in the folder: `recording,ctl.Kp,ctl.Kd` and a row for each recording."""

SAME = 1e-6
"""Relative difference up to which two values of a gain are the same."""


@dataclass(frozen=True)
class RecordedRun:
    """One recording and its gains.

    Attributes
    ----------
    gains : mapping of str to float
        By name [unit of the FMU parameter].
    path : Path or None
        None where the index says that the run failed.
    """

    gains: Mapping[str, float]
    path: Path | None

    def made_at(self, gains: Mapping[str, float]) -> bool:
        """Whether it was made at these gains; only gains that it names are compared."""
        return all(
            np.isclose(value, gains[name], rtol=SAME)
            for name, value in self.gains.items()
            if name in gains
        )


@dataclass(frozen=True)
class RecordedGrid:
    """Replays recordings, each only once, since a repetition carries no information.

    Attributes
    ----------
    folder : Path
        Folder of the recordings.
    runs : tuple of RecordedRun
        In the order of their names.
    reading : SignalReading or None
        Tells which columns are signals, as a twin file does.
    content_hash : str
        Hash of the gains and files of all runs.
    """

    folder: Path
    runs: tuple[RecordedRun, ...]
    reading: SignalReading | None = None
    content_hash: str = ""

    @classmethod
    def open(cls, folder: Path, reading: SignalReading | None = None) -> Self:
        """Open a folder of recordings.

        Parameters
        ----------
        folder : Path
            Recordings, and `gains.csv` where these do not name their gains themselves.
        reading : SignalReading or None
            Tells which columns are signals.

        Raises
        ------
        StudyFileError
            The folder does not exist, is empty, or holds a recording without known gains.
        """
        if not folder.is_dir():
            raise StudyFileError(f"[is1] recorded: no folder {folder}; give one with recordings")
        index = folder / INDEX
        runs = _indexed(index) if index.is_file() else _named_in_files(folder, reading)
        if not runs:
            raise StudyFileError(
                f"[is1] recorded: no recording in {folder}; put in one file for each run, with "
                f"its gains in '# NAME = VALUE' lines or in {INDEX}"
            )
        digest = hashlib.sha256()
        for run in runs:
            digest.update(repr(sorted(run.gains.items())).encode())
            if run.path is not None and run.path.is_file():
                digest.update(run.path.read_bytes())
        return cls(folder, tuple(runs), reading, digest.hexdigest())

    @property
    def name(self) -> str:
        """Name of the folder."""
        return self.folder.name

    def knowing(self, names: Iterable[str]) -> Self:
        """Grid whose recordings have only the gains of these names.

        Raises
        ------
        StudyFileError
            A recording lacks one of them.
        """
        wanted, kept = tuple(names), []
        for run in self.runs:
            missing = [name for name in wanted if name not in run.gains]
            if missing:
                label = run.path.name if run.path else INDEX
                raise StudyFileError(
                    f"[is1] recorded: {self.folder / label} does not say at which '{missing[0]}' "
                    f"it was made; add a line '# {missing[0]} = VALUE' or list it in {INDEX}"
                )
            kept.append(replace(run, gains={name: run.gains[name] for name in wanted}))
        return replace(self, runs=tuple(kept))

    def left(self, played: Sequence[Mapping[str, float]]) -> list[RecordedRun]:
        """Recordings not replayed yet, after real runs at the gains `played`."""
        left = list(self.runs)
        for gains in played:
            used = next((run for run in left if run.made_at(gains)), None)
            if used is not None:
                left.remove(used)
        return left

    def after(self, played: Sequence[Mapping[str, float]]) -> Self:
        """Grid without the replayed recordings; repeats at equal gains are removed one by one."""
        return replace(self, runs=tuple(self.left(played)))

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        """Replay the recording that was made at exactly these gains.

        Raises
        ------
        InputError
            There is no such recording.
        """
        found = next((run for run in self.runs if run.made_at(gains)), None)
        if found is None:
            asked = ", ".join(f"{name} = {value:g}" for name, value in gains.items())
            raise InputError(f"{self.name}: nothing is left that was recorded at {asked}")
        if found.path is None:
            return failed_run(reference, f"{self.name}: recorded as failed", name=self.name)
        try:
            return read_recording(found.path, self.reading)
        except RecordingError as error:
            return failed_run(reference, str(error), name=self.name)

    def close(self) -> None:
        """Do nothing."""


def _named_in_files(folder: Path, reading: SignalReading | None) -> list[RecordedRun]:
    files = sorted(path for path in folder.iterdir() if path.is_file() and path.name[0] not in "._")
    runs = []
    for path in files:
        if path.suffix.lower() in (".toml", ".md", ".json"):
            continue  # notes about the recordings
        try:
            runs.append(RecordedRun(read_recording(path, reading).parameters, path))
        except RecordingError as error:
            raise StudyFileError(f"[is1] recorded: {error}") from None
    return runs


def _indexed(index: Path) -> list[RecordedRun]:
    try:
        rows = list(csv.reader(index.read_text(encoding="utf-8-sig").splitlines()))
    except (OSError, UnicodeDecodeError) as error:
        raise StudyFileError(f"[is1] recorded: {index}: cannot be read: {error}") from None
    rows = [[cell.strip() for cell in row] for row in rows if any(cell.strip() for cell in row)]
    if not rows or rows[0][0] != "recording" or len(rows[0]) < 2:
        raise StudyFileError(
            f"[is1] recorded: {index}: expected a first line such as 'recording,ctl.Kp,ctl.Kd', "
            f"got '{','.join(rows[0]) if rows else ''}'"
        )
    return [
        _indexed_run(index, number, rows[0][1:], row)
        for number, row in enumerate(rows[1:], start=2)
    ]


def _indexed_run(index: Path, line: int, names: list[str], row: list[str]) -> RecordedRun:
    try:
        gains = {name: float(cell) for name, cell in zip(names, row[1:], strict=True)}
    except ValueError:
        raise StudyFileError(
            f"[is1] recorded: {index}, line {line}: expected a recording and {len(names)} numbers, "
            f"got '{','.join(row)}'; correct the line"
        ) from None
    path = index.parent / row[0] if row[0] else None
    if path is not None and not path.is_file():
        raise StudyFileError(
            f"[is1] recorded: {index}, line {line}: no recording '{row[0]}'; leave the cell blank "
            "for a run that failed"
        )
    return RecordedRun(gains, path)
