"""Runners of jobs: this process, or a worker process."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path, PurePosixPath
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import FmuFileError
from gmfbo.files.private_folder import PrivateFolder
from gmfbo.sources.binding.binding import Binding, content_of
from gmfbo.sources.fmu_file.job import Job, Outcome
from gmfbo.sources.fmu_file.unpacked_fmu import UnpackedFmu
from gmfbo.sources.fmu_file.unpacking import unpack

_NOT_NEEDED = ("sources", "documentation")


class Order(NamedTuple):
    """A job and its arrays: inputs u and schedules s, shape (steps, n)."""

    job: Job
    u: NDArray[np.float64]
    s: NDArray[np.float64]


class Result(NamedTuple):
    """Outcome of a job, and its outputs y, shape (steps + 1, n), valid up to `outcome.rows`."""

    outcome: Outcome
    y: NDArray[np.float64]


class Runner(Protocol):
    """Runs jobs of one twin, one after the other."""

    def run(self, *orders: Order) -> list[Result]:
        """Simulate each order on new instances, up to the first that does not end well."""
        ...

    def close(self) -> None:
        """Give back process, memory and folder."""
        ...


def unpack_fmus(binding: Binding, folder: Path) -> list[UnpackedFmu]:
    """Unpack the FMUs of a twin, with the library for this machine.

    Parameters
    ----------
    binding : Binding
        The twin.
    folder : Path
        Parent of a new folder for each FMU.

    Raises
    ------
    FmuFileError
        An FMU cannot be unpacked, or is not the one that was bound.
    """
    unpacked = []
    for index, fmu in enumerate(binding.fmus):
        if content_of(fmu.path) != binding.content[index]:
            raise FmuFileError(
                f"'{fmu.path}' changed after the twin was opened; open the twin again"
            )
        library = PurePosixPath(fmu.library().replace("\\", "/"))
        place = folder / f"fmu{index}"
        place.mkdir()
        unpack(fmu.path, place, partial(_is_needed, library.parent))
        (place / "resources").mkdir(exist_ok=True)
        unpacked.append(
            UnpackedFmu(
                name=fmu.path.name,
                guid=fmu.guid,
                identifier=fmu.identifier,
                folder=str(place),
                library=str(place / library),
                fmi=fmu.major,
            )
        )
    return unpacked


def _is_needed(binaries: PurePosixPath, member: PurePosixPath) -> bool:
    if member.parts[0] == "binaries":
        return binaries in member.parents
    return member.parts[0] not in _NOT_NEEDED


class InProcess:
    """Runs trusted FMUs in this process, which their crash, exit or hang would end too.

    Parameters
    ----------
    binding : Binding
        The twin.
    native : bool
        Step by the C master where there is one.
    """

    def __init__(self, binding: Binding, *, native: bool = True) -> None:
        from gmfbo.sources.stepping.simulator import Simulator

        self._folder = PrivateFolder()
        try:
            self._simulator = Simulator(unpack_fmus(binding, self._folder.path), native=native)
        except BaseException:
            self._folder.remove()
            raise

    def run(self, *orders: Order) -> list[Result]:
        """Simulate each order on new instances, up to the first that does not end well."""
        results = []
        folder = Path.cwd()
        try:
            for order in orders:
                y = np.full(order.job.shapes[2], np.nan)
                results.append(Result(self._simulator.run(order.job, order.u, order.s, y), y))
                if results[-1].outcome.status != "ok":
                    break
        finally:
            self._simulator.free()
            os.chdir(folder)  # some FMUs change it
        return results

    def close(self) -> None:
        """Remove the unpacked FMUs; their libraries stay loaded."""
        self._folder.remove()


def once_only(binding: Binding) -> Sequence[str]:
    """Names of the FMUs that allow one instance in the life of a process."""
    return [
        fmu.path.name
        for fmu in binding.fmus
        if fmu.capabilities.get("canBeInstantiatedOnlyOncePerProcess")
    ]
