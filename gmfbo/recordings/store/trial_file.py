"""One trial as an HDF5 file or group: datasets under `/`, provenance as attributes."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from gmfbo.errors import RecordingError, StoreError
from gmfbo.files.durable import cause
from gmfbo.recordings.formats.hdf5_group import group_content, with_prefix
from gmfbo.recordings.reading_process.reading_process import try_apart
from gmfbo.recordings.recording import recording_of
from gmfbo.recordings.store.seal import read_seal, sealed
from gmfbo.recordings.store.trial import Trial
from gmfbo.recordings.writing.hdf5_group import (
    DIGEST,
    GroupContent,
    content_digest,
    content_of,
    file_image,
    recording_content,
    texts,
    write_content,
)

_OPTIONAL = ("parent", "sigma_c", "accepted", "late_error")


@cache
def software_versions() -> Mapping[str, str]:
    """Versions of the installed packages that decide a result."""
    found = {"python": sys.version.split()[0]}
    for package in ("gmfbo", "numpy", "scipy", "h5py", "fmpy", "torch", "gpytorch", "botorch"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def trial_image(trial: Trial) -> bytes:
    """Bytes of the HDF5 file of one trial, with the seal that shows damage."""

    return sealed(file_image(lambda root: write_trial_group(root, trial)))


def write_trial_group(group: Any, trial: Trial) -> None:
    """Write a trial and the digest of its content into an empty group: the root of its file.

    Parameters
    ----------
    group : h5py.Group
        Empty.
    trial : Trial
        Its `gains` become two attributes, `gains` and `gain_names`, in one order; each metric
        one attribute `metric.<name>`; each version one attribute `version.<package>`.

    Raises
    ------
    RecordingError
        Two columns have one name, or HDF5 cannot hold a name.
    """
    content = _trial_content(trial)
    content.attributes[DIGEST] = content_digest(content)
    write_content(group, content)


def _trial_content(trial: Trial) -> GroupContent:
    content = recording_content(trial.recording)
    attributes = content.attributes
    for key in ("number", "source", "objective", "status", "started", "seconds", "seed", "twin"):
        attributes[key] = getattr(trial, key)
    for key in _OPTIONAL:
        if getattr(trial, key) is not None:
            attributes[key] = getattr(trial, key)
    attributes["gains"] = np.array(list(trial.gains.values()), dtype=np.float64)
    attributes["gain_names"] = texts(trial.gains)
    content.add_values("metric", trial.metrics)
    for package, number in (trial.versions or software_versions()).items():
        attributes[f"version.{package}"] = number
    attributes["uncorrected"] = texts(trial.uncorrected)
    attributes["std"] = texts(trial.std)
    units = trial.recording.units
    for name, values in trial.uncorrected.items():
        content.add_column(f"{name}_uncorrected", values, "uncorrected", units.get(name))
    for name, values in trial.std.items():
        content.add_column(f"{name}_std", values, "std", units.get(name))
    return content


def read_trial_group(group: Any) -> Trial:
    """Read a group written by `write_trial_group`."""
    attributes = dict(group.attrs)
    names = [str(name) for name in attributes["gain_names"]]
    parent, sigma_c, accepted, late = (attributes.get(key) for key in _OPTIONAL)
    return Trial(
        number=int(attributes["number"]),
        source=str(attributes["source"]),  # type: ignore[arg-type]
        gains=dict(zip(names, map(float, attributes["gains"]), strict=True)),
        recording=recording_of(*group_content(group, attributes)),
        objective=float(attributes["objective"]),
        metrics=with_prefix(attributes, "metric"),
        status=str(attributes["status"]),
        started=str(attributes["started"]),
        seconds=float(attributes["seconds"]),
        seed=int(attributes["seed"]),
        twin=str(attributes["twin"]),
        parent=None if parent is None else int(parent),
        sigma_c=None if sigma_c is None else float(sigma_c),
        accepted=None if accepted is None else bool(accepted),
        late_error=None if late is None else float(late),
        uncorrected={str(n): group[f"{n}_uncorrected"][()] for n in attributes["uncorrected"]},
        std={str(n): group[f"{n}_std"][()] for n in attributes["std"]},
        versions=with_prefix(attributes, "version"),
    )


def read_trial_file(path: Path) -> Trial:
    """Read one trial file; it takes no lock, as such a file is never written twice.

    A file without an intact seal is first read by another process, as damage in HDF5 may crash its
    reader. It counts as whole if its content matches its digest, since any program that opens the
    file for writing removes the seal.

    Raises
    ------
    StoreError
        The file is damaged, or is not a trial.
    """
    try:
        seal = read_seal(path.read_bytes()).state
    except OSError as error:
        raise StoreError(f"{path}: cannot be read: {cause(error)}") from error
    if seal != "intact":
        try:
            try_apart(path, try_trial_file)
        except RecordingError as error:
            raise damaged_trial(path, str(error)) from error
    try:
        return _read(path)
    except Exception as error:  # any exception may come out of h5py
        raise damaged_trial(path, f"{type(error).__name__}: {error}") from error


def try_trial_file(path: Path) -> None:
    """Read one trial file where a crash does no harm.

    Raises
    ------
    RecordingError
        Its content is damaged.
    """
    seal = read_seal(path.read_bytes()).state
    with h5py.File(path, "r", locking=False) as file:
        read_trial_group(file)
        # Files of an early version state no digest.
        if seal == "damaged" or DIGEST in file.attrs:
            check_digest(file)


def check_digest(group: Any) -> None:
    """Raise for a trial whose content contradicts its digest.

    Raises
    ------
    RecordingError
        The digest differs or is missing.
    """
    if group.attrs.get(DIGEST) != content_digest(content_of(group)):
        raise RecordingError("its content is not what was written")


def damaged_trial(path: Path, why: str) -> StoreError:
    """Error that tells how to go on without this trial."""
    why = " ".join(why.split())
    return StoreError(
        f"{path}: expected a whole trial file, but it is damaged ({why}); run "
        f"`gmfbo repair {path.parent.parent}`, which saves what can be saved"
    )


def _read(path: Path) -> Trial:
    with h5py.File(path, "r", locking=False) as file:
        return read_trial_group(file)
