"""Repair a study folder: damaged files are found, and mended or set aside.

Nothing is deleted: a damaged file is moved to the folder `damaged`, with its recovered part beside
it. Each step is a file written whole or moved, so a killed repair can be repeated.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from gmfbo.errors import RecordingError, StoreError, in_short
from gmfbo.files.durable import cause, sync_folder, write_whole
from gmfbo.files.toml_text import parse_toml, read_toml_text
from gmfbo.recordings.reading_process.reading_process import try_apart
from gmfbo.recordings.repair.salvage import save_signals
from gmfbo.recordings.store.events import EventLines, mend_events, read_events
from gmfbo.recordings.store.index import study_text_in_index
from gmfbo.recordings.store.seal import mended
from gmfbo.recordings.store.study_folder import LOCK_NAME, StudyStore
from gmfbo.recordings.store.study_reading import EVENTS_NAME, STUDY_NAME, FolderReading
from gmfbo.recordings.store.trial_file import read_trial_file
from gmfbo.recordings.store.writer_lock import WriterLock

DAMAGED = "damaged"


@dataclass
class RepairReport:
    """Report of a repair.

    Attributes
    ----------
    location : Path
        The usable study.
    whole, mended, lost : list of int
        Trials found whole, mended to the byte, and set aside.
    lines : list of str
        Each damage and its outcome, a line each; empty where nothing was damaged.
    """

    location: Path
    whole: list[int] = field(default_factory=list)
    mended: list[int] = field(default_factory=list)
    lost: list[int] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)


def repair_folder(folder: str | Path) -> RepairReport:
    """Repair a study folder.

    Parameters
    ----------
    folder : str or Path
        `NAME.study`; nobody else may be writing it.

    Returns
    -------
    RepairReport
        The study can be read and resumed.

    Raises
    ------
    StoreError
        It is no study folder, another process writes it, its study file is lost, or the folder
        cannot be written; the message says what is whole.
    """
    folder = Path(folder)
    if not folder.is_dir() or not any(
        (folder / name).exists() for name in (STUDY_NAME, "trials", EVENTS_NAME)
    ):
        raise StoreError(
            f"{folder}: expected a study folder or a packed study, but this is none; name the "
            "folder that `gmfbo tune` wrote"
        )
    try:
        lock = WriterLock(folder / LOCK_NAME)
    except OSError as error:
        raise StoreError(_read_only(folder, error)) from error
    try:
        return _repair(folder, lock)
    except OSError as error:
        raise StoreError(
            f"{folder}: the repair stopped half way: {cause(error)}; what is whole is untouched, "
            "repeat the repair then"
        ) from error
    finally:
        lock.release()


def _repair(folder: Path, lock: WriterLock) -> RepairReport:
    report = RepairReport(folder)
    _repair_study_file(folder, report)
    (folder / "trials").mkdir(exist_ok=True)
    reading = FolderReading(folder)
    for number in reading.numbers():
        _repair_trial(reading.trial_path(number), number, report)
    _repair_events(folder, report)
    with StudyStore(FolderReading(folder), lock) as store:
        unfinished = store.clear_away()
        if unfinished:
            report.lines.append(f"unfinished files of a killed writer removed: {len(unfinished)}")
        if report.mended or report.lost:
            store.log("repair", mended_trials=report.mended, lost_trials=report.lost)
    return report


def _repair_study_file(folder: Path, report: RepairReport) -> None:
    """Restore the study file from its copy in the index."""
    path, copy = folder / STUDY_NAME, study_text_in_index(folder)
    problem = _study_problem(path)
    if problem and copy is None:
        reading = folder / "trials"
        raise StoreError(
            f"{path}: {problem}, and {folder / 'index.h5'} holds no copy; put the study file that "
            f"the study was begun with there and repair again: {len(list(reading.glob('*.h5')))} "
            "trial files are waiting"
        )
    if problem and copy is not None:
        kept = f"; the damaged one is {_set_aside(path)}" if path.exists() else ""
        write_whole(path, copy.encode("utf-8"))
        report.lines.append(f"{STUDY_NAME}: {problem}; brought back from index.h5{kept}")
    elif copy is not None and path.read_bytes() != copy.encode("utf-8"):
        beside = _free(folder / DAMAGED / f"{STUDY_NAME}.from-index")
        write_whole(beside, copy.encode("utf-8"))
        report.lines.append(
            f"{STUDY_NAME}: differs from the copy in index.h5, which is now {beside}; if nobody "
            "has edited it, put the copy in its place"
        )


def _study_problem(path: Path) -> str:
    try:
        parse_toml(read_toml_text(path))
    except FileNotFoundError:
        return "missing"
    except ValueError as error:
        return f"damaged ({in_short(error)})"
    return ""


def _repair_trial(path: Path, number: int, report: RepairReport) -> None:
    why = _trial_problem(path, number)
    corrected = mended(path.read_bytes())
    if corrected is not None:
        content, byte = corrected
        aside = _copy_aside(path)
        write_whole(path, content)
        why = _trial_problem(path, number)
        report.lines.append(
            f"trial {number}: one bit of byte {byte} had turned; mended to the byte, the damaged "
            f"file is {aside}"
        )
    if why:
        saved = _save_signals(path)
        aside = _set_aside(path)
        report.lines.append(f"trial {number}: {why}; moved to {aside}; {saved}")
    found = report.lost if why else report.whole if corrected is None else report.mended
    found.append(number)


def _trial_problem(path: Path, number: int) -> str:
    """Problem of a trial file; empty where there is none."""
    try:
        held = read_trial_file(path).number
    except StoreError as error:
        return str(error).partition("but it is ")[2].rpartition("; run")[0] or str(error)
    return "" if held == number else f"holds trial {held}"


def _save_signals(path: Path) -> str:
    out = _free(path.parents[1] / DAMAGED / f"{path.stem}.saved.h5")
    try:
        try_apart(path, save_signals, out=str(out.absolute()))
    except RecordingError as error:
        return f"nothing of it can be saved ({error})"
    return f"the signals that can be read are the recording {out}, unverified"


def _repair_events(folder: Path, report: RepairReport) -> None:
    path = folder / EVENTS_NAME
    if not path.exists():
        return
    content = path.read_bytes()
    corrected, lines = mend_events(content)
    if lines:
        aside = _copy_aside(path)
        write_whole(path, corrected)
        report.lines.append(
            f"{EVENTS_NAME}: one bit had turned in {_lines(lines)}; mended, the damaged file is "
            f"{aside}"
        )
    damaged = read_events(corrected).damaged
    if damaged:
        report.lines.append(f"{EVENTS_NAME}: {_lines(damaged)} damaged; passed over from now on")


def _lines(numbers: list[int]) -> str:
    return f"line{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}"


def _set_aside(path: Path) -> Path:
    aside = _aside(path)
    path.replace(aside)
    sync_folder(aside.parent)
    sync_folder(path.parent)
    return aside


def _copy_aside(path: Path) -> Path:
    aside = _aside(path)
    write_whole(aside, path.read_bytes())
    return aside


def _aside(path: Path) -> Path:
    folder = path.parents[1] if path.parent.name == "trials" else path.parent
    return _free(folder / DAMAGED / path.name)


def _free(path: Path) -> Path:
    """Free file name, since an earlier repair may have set aside a file of this name."""
    path.parent.mkdir(exist_ok=True)
    count, free = 1, path
    while free.exists():
        count += 1
        free = path.with_name(f"{path.stem} ({count}){path.suffix}")
    return free


def _read_only(folder: Path, error: OSError) -> str:
    """Error that tells why nothing can be repaired, and which trials are whole."""
    reading, whole, damaged = FolderReading(folder), 0, []
    for number in reading.numbers():
        try:
            reading.read_trial(number)
            whole += 1
        except StoreError:
            damaged.append(number)
    events: EventLines = reading.event_lines()
    bad = f", damaged are {', '.join(map(str, damaged))}" if damaged else ""
    lines = f" and {_lines(events.damaged)} of {EVENTS_NAME}" if events.damaged else ""
    return (
        f"{folder}: cannot repair: {cause(error)}; {whole} trials are whole{bad}{lines}; repair a "
        "copy of the folder"
    )
