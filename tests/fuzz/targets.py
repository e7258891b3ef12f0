"""What is fuzzed: a reader, the files it is given, and what it may cost."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from hypothesis import strategies as st

from gmfbo.errors import GmfboError
from gmfbo.recordings.columns.column_mapping import DIALECTS
from gmfbo.recordings.reader import read_columns
from gmfbo.recordings.recording import read_recording
from gmfbo.recordings.repair.repair_folder import repair_folder
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.sources.binding.bind import bind
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.fmu_file.unpacking import unpack
from gmfbo.sources.inspection.inspection import inspect_fmu, starting_twin_file
from gmfbo.sources.inspection.ssp_import import import_ssp
from gmfbo.sources.twin_file.twin_file import TwinFile
from gmfbo.tuning.study_file.study_file import read_study_file
from tests.fuzz import binary_files, fmus, packages, texts
from tests.fuzz.mutation import text_changes
from tests.recordings.twin_words import AXIS


@dataclass(frozen=True)
class Target:
    """One kind of file.

    Attributes
    ----------
    files : callable
        Makes the strategy; what it imports is loaded then.
    read : callable
        Given the file in a folder of its own, does all that gmfbo does with such a file.
    name : str
        File name.
    seconds, megabytes : float
        What one file may cost, in processor time and memory; for foreign formats in the
        reading process.
    apart : bool
        Read by the reading process, whose memory is then measured.
    """

    files: Callable[[], st.SearchStrategy[bytes]]
    read: Callable[[Path], None]
    name: str
    seconds: float = 5.0
    megabytes: float = 300.0
    apart: bool = False


def _read_fmu(path: Path) -> None:
    before = _tree(path.parent)
    inside = path.parent / "deep" / "inside"
    inside.mkdir(parents=True)
    try:
        report = inspect_fmu(path)
        text = starting_twin_file(report)
        TwinFile.parse(text, "started.toml", path.parent)
    finally:
        try:
            unpack(path, inside, lambda member: True)
        finally:
            _refuse_escape(inside)
            shutil.rmtree(path.parent / "deep")
            assert _tree(path.parent) == before, "written outside the folder"


def _refuse_escape(inside: Path) -> None:
    for made in inside.rglob("*"):
        assert not made.is_symlink(), f"a link was made: {made}"


def _tree(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


def _read_twin(path: Path) -> None:
    file = TwinFile.read(path)
    for fmu in models_folder().glob("*.fmu"):
        link = path.parent / fmu.name
        if not link.exists():
            link.symlink_to(fmu)
    bind(file, path.parent, path.name)


def _read_package(path: Path) -> None:
    before, folder = _tree(path.parent), path.parent / "deep" / "inside"
    folder.mkdir(parents=True)
    try:
        import_ssp(path, folder)
    finally:
        _refuse_escape(folder)
        shutil.rmtree(path.parent / "deep")
        assert _tree(path.parent) == before, "written outside the folder"


def _read_study(path: Path) -> None:
    read_study_file(path)


def _read_text_recording(path: Path) -> None:
    _expect_own_error(partial(read_recording, path))
    for dialect in DIALECTS:
        _expect_own_error(partial(read_columns, path, dialect))
    read_recording(path, AXIS)


def _expect_own_error(read: Callable[[], object]) -> None:
    try:
        read()
    except GmfboError as refused:
        assert_one_line(refused)


def assert_one_line(refused: GmfboError) -> None:
    """A refusal is one line that a person can read to its end."""
    assert str(refused), "an empty message"
    assert len(str(refused)) < 3000, f"a message of {len(str(refused))} characters"


def _read_foreign(path: Path) -> None:
    read_recording(path)
    _expect_own_error(partial(read_recording, path, AXIS))


def _read_stored_trial(path: Path) -> None:
    folder = path.parent / "a.study"
    StudyStore.create(folder, "").close()
    target = folder / "trials" / "000001.h5"
    target.write_bytes(path.read_bytes())
    try:
        with StudyStore.open(folder) as store:
            store.trials()
    except GmfboError:
        assert repair_folder(folder).whole == []
        assert all(trial.number == 1 for trial in StudyStore.open(folder).trials())
        raise
    finally:
        shutil.rmtree(folder)


def _read_packed(path: Path) -> None:
    with StudyStore.open(path) as store:
        _ = store.study_text, store.trials(), store.events()


def _read_events(path: Path) -> None:
    folder = path.parent / "a.study"
    StudyStore.create(folder, "").close()
    (folder / "events.jsonl").write_bytes(path.read_bytes())
    try:
        with StudyStore.open_for_writing(folder) as store:
            store.log("note")
            assert store.events()[-1]["event"] == "note"
        repair_folder(folder)
    finally:
        shutil.rmtree(folder)


# A library that loops in a foreign file, or fills the memory, is ended by the reading process
# at 6 s of computing and some 1 GiB; most files take milliseconds.
def _apart(
    files: Callable[[], st.SearchStrategy[bytes]], read: Callable[[Path], None], name: str
) -> Target:
    return Target(files, read, name, seconds=10.0, megabytes=2**30 / 1e6, apart=True)


TARGETS: Mapping[str, Target] = {
    "FMU archive": Target(fmus.hostile_archives, _read_fmu, "a.fmu"),
    "FMU description": Target(fmus.hostile_descriptions, _read_fmu, "a.fmu"),
    "SSP package": Target(packages.hostile_packages, _read_package, "a.ssp"),
    "twin file": Target(lambda: text_changes(texts.twin_files()), _read_twin, "a.toml"),
    "study file": Target(lambda: text_changes(texts.study_files()), _read_study, "a.toml"),
    "CSV": Target(lambda: text_changes(texts.csv_files()), _read_text_recording, "a.csv"),
    "HDF5": _apart(binary_files.hdf5, _read_foreign, "a.h5"),
    "MAT v5": _apart(binary_files.mat_v5, _read_foreign, "a.mat"),
    "MAT v7.3": _apart(binary_files.mat_v73, _read_foreign, "a.mat"),
    "Parquet": _apart(binary_files.parquet, _read_foreign, "a.parquet"),
    "MDF": _apart(binary_files.mdf, _read_foreign, "a.mf4"),
    "TDMS": _apart(binary_files.tdms, _read_foreign, "a.tdms"),
    "stored trial": _apart(binary_files.stored_trials, _read_stored_trial, "a.h5"),
    "packed study": _apart(binary_files.packed_studies, _read_packed, "a.h5"),
    "events": Target(binary_files.event_files, _read_events, "events.jsonl"),
}
