"""Repair a packed study: its whole trials become a study folder."""

from __future__ import annotations

import tempfile
from pathlib import Path

from gmfbo.errors import RecordingError, StoreError
from gmfbo.files.durable import cause, write_whole
from gmfbo.recordings.reading_process.reading_process import try_apart
from gmfbo.recordings.repair.repair_folder import RepairReport
from gmfbo.recordings.repair.salvage import list_packed_trials, save_packed_study, save_packed_trial
from gmfbo.recordings.store.pack import PackedReading
from gmfbo.recordings.store.seal import mended
from gmfbo.recordings.store.study_folder import StudyStore


def repair_packed(path: str | Path) -> RepairReport:
    """Repair a packed study; the file itself stays as it is.

    One wrong bit is corrected and the file written as `NAME.repaired.h5`; otherwise each trial with
    a valid digest goes to the study folder `NAME.repaired.study`.

    Parameters
    ----------
    path : str or Path
        File that `gmfbo export --pack` wrote.

    Raises
    ------
    StoreError
        Nothing can be saved, or the result cannot be written.
    """
    path = Path(path)
    try:
        reading = PackedReading(path)
        return RepairReport(path, whole=reading.numbers())
    except StoreError as error:
        why = str(error)
    try:
        corrected = mended(path.read_bytes())
        if corrected is None:
            return _save_trials(path, why)
        target = path.with_name(f"{path.stem}.repaired{path.suffix}")
        _refuse_existing(target)
        write_whole(target, corrected[0])
    except OSError as error:
        raise StoreError(f"{path}: cannot be repaired: {cause(error)}") from error
    report = RepairReport(target, mended=PackedReading(target).numbers())
    report.lines.append(
        f"one bit of byte {corrected[1]} had turned; mended to the byte in {target}"
    )
    return report


def _save_trials(path: Path, why: str) -> RepairReport:
    folder = path.with_name(f"{path.stem}.repaired.study")
    _refuse_existing(folder)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.stem}.") as name:
        made = Path(name)
        (made / "trials").mkdir()
        try:
            try_apart(path, save_packed_study, folder=name)
            try_apart(path, list_packed_trials, out=str(made / "numbers"))
        except RecordingError as error:
            raise StoreError(f"{why}; nothing can be saved of it ({error})") from error
        numbers = [int(line) for line in (made / "numbers").read_text().splitlines()]
        (made / "numbers").unlink()
        report = RepairReport(folder)
        for number in numbers:
            try:
                try_apart(
                    path,
                    save_packed_trial,
                    number=str(number),
                    folder=str(made / "trials"),
                )
                report.whole.append(number)
            except RecordingError as error:
                report.lost.append(number)
                report.lines.append(f"trial {number}: cannot be saved ({error})")
        StudyStore.open_for_writing(made).close()
        made.rename(folder)
        made.mkdir()  # the temporary folder can then be removed
    report.lines.append(f"what is whole is the study folder {folder}")
    return report


def _refuse_existing(target: Path) -> None:
    if target.exists():
        raise StoreError(f"{target}: is there already, from an earlier repair; move it away first")
