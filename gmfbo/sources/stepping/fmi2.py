"""An FMI 2.0 FMU's library, loaded once, and its instances."""

from __future__ import annotations

import ctypes
import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, ClassVar

import fmpy.fmi2
from fmpy.fmi1 import FMICallException

from gmfbo.errors import FmuFileError, SimulationError
from gmfbo.sources.fmu_file.job import ArrayElement, Setting, Stage, TextSetting, ValueType
from gmfbo.sources.fmu_file.unpacked_fmu import UnpackedFmu
from gmfbo.sources.stepping.fmu_log import FmuLog
from gmfbo.sources.stepping.interface import FMI2, Interface, Values, crossing
from gmfbo.sources.stepping.library_beside import with_libraries_beside

STATUS_WORDS = ("ok", "warning", "discard", "error", "fatal", "pending")
ERROR = 3
_TERMINATED = 3  # of fmi2StatusKind
_FOREIGN = r"invalid ELF header|wrong ELF class|not a valid Win32|incompatible arch"


class FmuCallError(SimulationError):
    """An FMU refused a call; the text holds the call and the FMU's log.

    Attributes
    ----------
    stage : Stage
        Request to the FMU.
    status : int
        FMI status of the answer.
    """

    def __init__(self, message: str, stage: Stage, status: int) -> None:
        super().__init__(message)
        self.stage = stage
        self.status = status


def _absent(*_: object) -> int:
    return ERROR


ABSENT = ctypes.CFUNCTYPE(ctypes.c_int)(_absent)
"""Placeholder for an optional function that a library lacks."""


class FMU2TolerantSlave(fmpy.fmi2.FMU2Slave):  # type: ignore[misc]  # fmpy is untyped
    """A slave whose library may lack optional functions, as some vendors' do.

    fmpy tells the FMI version by the first letters of the class name.
    """

    def _loadFunctions(self) -> None:
        self.absent = {
            name for name in dir(self) if name.startswith("fmi2") and not hasattr(self.dll, name)
        }
        for name in self.absent:
            setattr(self.dll, name, ABSENT)
        super()._loadFunctions()


class LoadedFmu:
    """The library of one FMU; it stays loaded, since unloading crashes some vendors' FMUs.

    Parameters
    ----------
    unpacked : UnpackedFmu
        The unpacked FMU.

    Raises
    ------
    FmuFileError
        The library cannot be loaded; the message names what is missing and the cure.
    """

    interface: ClassVar[Interface] = FMI2
    slave_class: ClassVar[type] = FMU2TolerantSlave
    required: ClassVar[Sequence[str]] = (
        "fmi2Instantiate",
        "fmi2FreeInstance",
        "fmi2SetupExperiment",
        "fmi2EnterInitializationMode",
        "fmi2ExitInitializationMode",
        "fmi2SetReal",
        "fmi2GetReal",
        "fmi2DoStep",
    )

    def __init__(self, unpacked: UnpackedFmu) -> None:
        self.name = unpacked.name
        self._log = FmuLog()
        folder = Path.cwd()
        try:
            self._slave: Any = with_libraries_beside(
                Path(unpacked.library),
                lambda: self.slave_class(
                    guid=unpacked.guid,
                    modelIdentifier=unpacked.identifier,
                    unzipDirectory=unpacked.folder,
                    libraryPath=unpacked.library,
                ),
            )
        except Exception as error:
            # fmpy raises a bare Exception with the loader's text.
            raise FmuFileError(_load_problem(unpacked, str(error))) from None
        finally:
            os.chdir(folder)  # fmpy leaves another working folder when loading fails
        missing = sorted(set(self.required) & self._slave.absent)
        if missing:
            raise FmuFileError(
                f"'{unpacked.name}': its library lacks {', '.join(missing)}; expected FMI "
                f"{self.interface.major}.0 co-simulation; ask its vendor for a complete export"
            )

    def instantiate(self) -> Instance:
        """Make a new instance.

        Raises
        ------
        FmuCallError
            The FMU refused.
        """
        self._log.lines.clear()
        self._slave.component = None
        try:
            self._slave.instantiate(callbacks=self._log.callbacks)
        except Exception:
            # fmpy raises a bare Exception when the FMU returns a null pointer.
            if self._slave.component is not None:
                raise
            refused = self.refusal("fmi2Instantiate", None)
            raise FmuCallError(refused, Stage.INSTANTIATE, ERROR) from None
        return Instance(self, self._slave, ctypes.c_void_p(self._slave.component))

    def refusal(self, call: str, status: int | None) -> str:
        """Message for a call that did not return ok.

        Parameters
        ----------
        call : str
            FMI function.
        status : int or None
            Its status; None where the call returns a pointer.
        """
        answer = "" if status is None else f" with '{_status_word(status)}'"
        said = f": {'; '.join(self._log.lines)}" if self._log.lines else ""
        return f"'{self.name}' refused {call}{answer}{said}"


class Instance:
    """One instance of an FMU, from instantiation until `free`."""

    interface: ClassVar[Interface] = FMI2

    def __init__(self, fmu: LoadedFmu, slave: Any, component: ctypes.c_void_p) -> None:
        self.fmu = fmu
        self.component = component
        self._slave = slave

    def initialise(
        self,
        start: float,
        settings: Sequence[Setting],
        texts: Sequence[TextSetting] = (),
        stop: float | None = None,
    ) -> None:
        """Set parameters and go through initialisation.

        Parameters
        ----------
        start : float
            [s] Time of the first communication point.
        settings : sequence of Setting
            Parameters of this FMU that are numbers.
        texts : sequence of TextSetting
            Parameters of this FMU that are texts.
        stop : float or None
            [s] Stop time that is announced; None announces none.

        Raises
        ------
        FmuCallError
            The FMU refused.
        """
        for kind in self.interface.words:
            of_kind = [setting for setting in settings if setting.type == kind]
            self._set_arrays(kind, [s for s in of_kind if ArrayElement.of(s.reference)])
            chosen = [s for s in of_kind if not ArrayElement.of(s.reference)]
            if chosen:
                values = self.interface.room(kind, len(chosen))
                values[:] = [crossing(setting.value, kind) for setting in chosen]
                references = _references(setting.reference for setting in chosen)
                self.set_values(kind, references, values, Stage.INITIALISE)
        if texts:
            self._set_texts(_references(text.reference for text in texts), [t.value for t in texts])
        self._enter(start, stop)

    def set_values(
        self, kind: ValueType, references: Values, values: Values, stage: Stage = Stage.STEP
    ) -> int:
        """Set values of one type; the status, at most a warning.

        Parameters
        ----------
        kind : ValueType
            Type that the interface has.
        references, values : ctypes array
            Of `c_uint` and of the interface's type.
        stage : Stage
            For the error.

        Raises
        ------
        FmuCallError
            The FMU refused.
        """
        setter = self.interface.setter(kind)
        return self.call(setter, stage, references, len(references), values)

    def get_values(self, kind: ValueType, references: Values, values: Values) -> int:
        """Read values of one type; the status, at most a warning.

        Parameters
        ----------
        kind : ValueType
            Type that the interface has.
        references, values : ctypes array
            Of `c_uint` and of the interface's type; `values` is filled.

        Raises
        ------
        FmuCallError
            The FMU refused.
        """
        getter = self.interface.getter(kind)
        return self.call(getter, Stage.STEP, references, len(references), values)

    def step(self, time: float, step: float) -> int:
        """Make one communication step; the status, at most a warning.

        Parameters
        ----------
        time : float
            [s] Communication point at which it begins.
        step : float
            [s] Its length.

        Raises
        ------
        FmuCallError
            The FMU refused, or asks for an unsupported feature.
        """
        return self.call(self.interface.do_step, Stage.STEP, time, step, 1)

    def call(self, function: str, stage: Stage, *arguments: Any) -> int:
        """Call one FMI function on the component; the status, at most a warning.

        Raises
        ------
        FmuCallError
            The status is discard or above.
        """
        try:
            return int(getattr(self._slave, function)(self.component, *arguments))
        except FMICallException as error:
            refused = self.fmu.refusal(function, error.status)
            raise FmuCallError(refused, stage, error.status) from None

    def has_ended(self) -> bool:
        """Whether the FMU discarded a step because it ended the simulation."""
        told = ctypes.c_int(0)
        try:
            self.call("fmi2GetBooleanStatus", Stage.STEP, _TERMINATED, ctypes.byref(told))
        except FmuCallError:
            return False
        return bool(told.value)

    def address(self, function: str) -> int | None:
        """Address of an FMI function of the library; None where the library lacks it."""
        if function in self._slave.absent:
            return None
        return ctypes.cast(getattr(self._slave.dll, function), ctypes.c_void_p).value

    def free(self) -> None:
        """Free the instance; the library stays loaded."""
        self._slave.fmi2FreeInstance(self.component)

    def _set_arrays(self, kind: ValueType, settings: Sequence[Setting]) -> None:
        """Set whole arrays of which each element is given."""
        arrays: dict[int, Values] = {}
        for setting in settings:
            element = ArrayElement.of(setting.reference)
            assert element is not None  # the caller has chosen them
            if element.reference not in arrays:
                arrays[element.reference] = self.interface.room(kind, element.size)
            arrays[element.reference][element.place] = crossing(setting.value, kind)
        for reference, values in arrays.items():
            self.set_values(kind, _references([reference]), values, Stage.INITIALISE)

    def _set_texts(self, references: Any, values: Sequence[str]) -> None:
        raw = (ctypes.c_char_p * len(values))(*(value.encode() for value in values))
        self.call("fmi2SetString", Stage.INITIALISE, references, len(values), raw)

    def _enter(self, start: float, stop: float | None) -> None:
        # Of 78 third-party FMUs, 27 refuse the last step when a stop time was announced.
        announced = (0, 0.0) if stop is None else (1, stop)
        self.call("fmi2SetupExperiment", Stage.INITIALISE, 0, 0.0, start, *announced)
        self.call("fmi2EnterInitializationMode", Stage.INITIALISE)
        self.call("fmi2ExitInitializationMode", Stage.INITIALISE)


def _references(references: Iterable[int]) -> Any:
    values = list(references)
    return (ctypes.c_uint * len(values))(*values)


def _status_word(status: int) -> str:
    return STATUS_WORDS[status] if 0 <= status < len(STATUS_WORDS) else f"status {status}"


def _load_problem(unpacked: UnpackedFmu, text: str) -> str:
    """Problem and cure, from the loader's message."""
    beginning = f"'{unpacked.name}': its library cannot be loaded"
    missing = re.search(r"(\S+): cannot open shared object", text)
    # For another processor, the loader reports the library itself as missing.
    if missing and missing[1] != unpacked.library:
        return (
            f"{beginning}: it needs the system library {missing[1]}, which is not installed; "
            f"install the package that provides {missing[1]}"
        )
    if version := re.search(r"version [`'](\w+_[\d.]+)' not found", text):
        return (
            f"{beginning}: it needs {version[1]}, this system is older; use a newer system, or ask "
            "its vendor for a build for older ones"
        )
    if symbol := re.search(r"undefined symbol: (\S+)", text):
        return (
            f"{beginning}: it needs the function {symbol[1]}, which no loaded library has; ask its "
            "vendor for an export with all its libraries"
        )
    if missing or re.search(_FOREIGN, text):
        return (
            f"{beginning}: it was built for another kind of machine than the folder that it lies "
            "in says; ask its vendor for a corrected export"
        )
    if "or one of its dependencies" in text:
        return (
            f"{beginning}: it needs another DLL, often the Microsoft Visual C++ Redistributable; "
            "install that, or ask its vendor which it is"
        )
    return f"{beginning} ({' '.join(text.split())}); ask its vendor"
