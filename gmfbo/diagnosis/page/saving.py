"""A diagnosis as files in a folder, each whole or not at all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.diagnosis.page.page import diagnosis_page
from gmfbo.diagnosis.result.diagnosis_json import diagnosis_text
from gmfbo.errors import GmfboError, InputError
from gmfbo.files.durable import cause, write_whole
from gmfbo.files.private_folder import PrivateFolder
from gmfbo.sources.export.augmented_file import with_origin
from gmfbo.sources.twin_file.twin_file import TwinFile

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.findings import Findings

NEXT_FILE = "next.csv"
CONFIRMATION_FILE = "confirmation.json"
"""What a recording said of an earlier diagnosis in the folder."""

TWIN_FILES = ("augmented.fmu", "augmented.toml")


def save(diagnosis: Findings, folder: Path) -> tuple[Path, ...]:
    """Write a diagnosis; see `gmfbo.Diagnosis.save`.

    Parameters
    ----------
    diagnosis : Findings
        Result of the diagnosis.
    folder : Path
        Made if it is not there.

    Returns
    -------
    tuple of Path
        The files written; `diagnosis.json` is written last, so that its presence proves the rest.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        twin_files, note = _write_twin(diagnosis, folder)
        told = replace(diagnosis, notes=(*diagnosis.notes, note)) if note else diagnosis
        played = _write_reference(diagnosis, folder)
        report, content = folder / "report.html", folder / "diagnosis.json"
        text = diagnosis_text(told).encode("utf-8")
        if not (content.is_file() and content.read_bytes() == text):
            (folder / CONFIRMATION_FILE).unlink(missing_ok=True)
        write_whole(report, diagnosis_page(told).encode("utf-8"))
        write_whole(content, text)
    except OSError as error:
        raise InputError(f"cannot write '{error.filename or folder}': {cause(error)}") from None
    return content, report, *twin_files, *played


def _write_twin(diagnosis: Findings, folder: Path) -> tuple[tuple[Path, ...], str]:
    if diagnosis.augmentation is None:
        return _kept_twin(diagnosis, folder), ""
    private = PrivateFolder()
    try:
        exported = diagnosis.augmentation.export(private.path)
        text = exported.twin_file.read_text(encoding="utf-8")
        text = with_origin(text, diagnosis.augmentation.twin_file, folder)
        contents = (exported.fmu.read_bytes(), text.encode("utf-8"))
        for content, name in zip(contents, TWIN_FILES, strict=True):
            write_whole(folder / name, content)
    except GmfboError as error:
        _remove_twin(folder)
        return (), f"no augmented twin was written: {error}"
    finally:
        private.remove()
    return tuple(folder / name for name in TWIN_FILES), ""


def _write_reference(diagnosis: Findings, folder: Path) -> tuple[Path, ...]:
    """Write the next reference as a file that a drive can play, and remove an older one."""
    told = diagnosis.next_experiment
    if told is None or not told.reference or not diagnosis.next_reference:
        (folder / NEXT_FILE).unlink(missing_ok=True)
        return ()
    write_whole(folder / told.reference, diagnosis.next_reference.encode("utf-8"))
    return (folder / told.reference,)


def _kept_twin(diagnosis: Findings, folder: Path) -> tuple[Path, ...]:
    """Copy the twin with which a diagnosis was read, and remove that of another diagnosis."""
    origin = diagnosis.exported
    if origin is None:
        _remove_twin(folder)
        return ()
    if origin.parent.resolve() != folder.resolve():
        for name in TWIN_FILES:
            write_whole(folder / name, _moved(origin.with_name(name), folder))
    return tuple(folder / name for name in TWIN_FILES)


def _moved(file: Path, folder: Path) -> bytes:
    """Content of one of the twin's files for another folder, with the way to its origin."""
    content = file.read_bytes()
    if file.suffix != ".toml" or (named := TwinFile.read(file).origin) is None:
        return content
    return with_origin(content.decode("utf-8"), file.parent / named, folder).encode("utf-8")


def _remove_twin(folder: Path) -> None:
    for name in TWIN_FILES:
        (folder / name).unlink(missing_ok=True)
