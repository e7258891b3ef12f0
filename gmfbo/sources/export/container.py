"""Join FMUs into one, with the runtime of fmu-manipulation-toolbox (BSD-2)."""

from __future__ import annotations

import importlib.metadata
import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gmfbo.errors import ExportError
from gmfbo.sources.export.container_wiring import Wiring

_TOOLBOX = "fmu-manipulation-toolbox"
_NAME = "container"
_LETTERS = {"real64": "R", "integer32": "I", "boolean": "B", "string": "T"}


@dataclass(frozen=True)
class Container:
    """A container FMU, still without model description and entry library.

    Attributes
    ----------
    resources : mapping of str to bytes
        By path below `resources/`: the FMUs, `container.txt` and the runtime's libraries.
    references : mapping of str to int
        Value references of its variables.
    types : mapping of str to str
        Type letter of each settable variable: R, I, B, or T for a text.
    time : int
        Value reference of the time.
    """

    resources: Mapping[str, bytes]
    references: Mapping[str, int]
    types: Mapping[str, str]
    time: int


def build_container(wiring: Wiring, step: float, folder: Path) -> Container:
    """Join FMUs; each internal step computes them in order, on the newest values.

    Parameters
    ----------
    wiring : Wiring
        FMUs to join, and their wires.
    step : float
        [s] Internal step.
    folder : Path
        Exists; the toolbox works in it.

    Raises
    ------
    ExportError
        The toolbox cannot join them.
    """
    from fmu_manipulation_toolbox.container import FMUContainerError

    with _quiet():
        try:
            built = _build(wiring, step, folder)
        except FMUContainerError as error:
            reason = " ".join(str(error.reason).split())
            raise ExportError(
                f"the FMUs cannot be joined into one: {reason}; the diagnosis holds without it"
            ) from None
    references = {**built.layout.inputs, **built.layout.outputs}
    for name, same in wiring.same_as.items():
        references[name] = references[same]
    types = {name: _LETTERS[port.type_name] for name, port in built.inputs.items()}
    return Container(_resources(folder / _NAME), references, types, built.layout.time)


def _build(wiring: Wiring, step: float, folder: Path) -> Any:
    from fmu_manipulation_toolbox.container import FMUContainer

    class Described(FMUContainer):  # type: ignore[misc]  # the toolbox is untyped
        """Toolbox container without model description, whose units and bounds the toolbox drops."""

        def make_fmu_xml(self, *arguments: Any) -> None:
            self.layout = arguments[-1]

        def make_fmu_package(self, *_: Any) -> None:
            """Write no archive: `container_archive` writes a reproducible one."""

        def make_fmu_cleanup(self, *_: Any) -> None:
            """Keep the folder, which is read afterwards."""

    container = Described(_NAME, folder)
    for name, path in wiring.members.items():
        member = container.get_fmu(str(path.resolve()), name)
        member.step_size = None  # not the vendor's step: the fitted one holds
    # The toolbox takes outputs only where a wire begins or a value is read.
    for end in (*wiring.wires.values(), *wiring.readable.values()):
        container.involved_fmu[end.member].ports[end.variable].causality = "output"
    for target, source in wiring.wires.items():
        container.add_link_regular(
            *(container.involved_fmu[source.member], source.variable),
            *(container.involved_fmu[target.member], target.variable),
        )
    for name, ends in wiring.settable.items():
        for end in ends:
            container.add_input(name, end.member, end.variable)
    for name, end in wiring.readable.items():
        container.add_output(end.member, end.variable, name)
    container.make_fmu(f"{_NAME}.fmu", step_size=step, sequential=True)
    return container


def _resources(folder: Path) -> dict[str, bytes]:
    files = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_file() and name.startswith("resources/"):
            files[name.removeprefix("resources/")] = path.read_bytes()
        elif path.is_file() and name.startswith("binaries/"):
            files[name.replace("binaries/", "runtime/", 1)] = path.read_bytes()
    return files


def toolbox_license() -> bytes:
    """License text that has to accompany the runtime."""
    files = importlib.metadata.files(_TOOLBOX) or []
    texts = [Path(str(file.locate())) for file in files if file.name.startswith("LICENSE")]
    return b"\n".join(path.read_bytes() for path in texts)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep the toolbox's remarks off the console; `exportable` has checked what matters."""
    logger = logging.getLogger("fmu_manipulation_toolbox")
    handler, before = logging.NullHandler(), logger.propagate
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield
    finally:
        logger.propagate = before
        logger.removeHandler(handler)
