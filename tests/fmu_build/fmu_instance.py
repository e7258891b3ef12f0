"""One instance of an FMU, stepped through fmpy: the tests' own way in, apart from the driver's."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2StepFinishedTYPE,
)
from numpy.typing import NDArray


class FmuInstance:
    """An instance with variables by name; a refused call raises with the FMU's own messages."""

    def __init__(self, unpacked: Path, guid: str | None = None) -> None:
        self.description = read_model_description(str(unpacked), validate=False)
        self.variables = {entry.name: entry for entry in self.description.modelVariables}
        self.messages: list[str] = []
        self.slave = FMU2Slave(
            guid=guid or self.description.guid,
            unzipDirectory=str(unpacked),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="tested",
        )
        self._callbacks = fmi2CallbackFunctions()
        self._callbacks.logger = fmi2CallbackLoggerTYPE(self._log)
        self._callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE()
        self._callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE()
        self._callbacks.stepFinished = fmi2StepFinishedTYPE()
        self.slave.instantiate(callbacks=self._callbacks)

    def _log(self, _: Any, name: bytes, status: int, category: bytes, message: bytes) -> None:
        self.messages.append(message.decode().replace("%%", "%"))

    def start(self, time: float = 0.0, **values: float) -> FmuInstance:
        """Set parameters and inputs (`.` in names written `__`) and initialise."""
        self.set(**values)
        self.slave.setupExperiment(startTime=time)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        return self

    def set(self, **values: float) -> None:
        """Set variables of any type."""
        for key, value in values.items():
            variable = self.variables[key.replace("__", ".")]
            setter = getattr(self.slave, f"set{variable.type}")
            self._call(setter, [variable.valueReference], [value])

    def get(self, name: str) -> float:
        """Value of a variable of any type."""
        variable = self.variables[name]
        return float(getattr(self.slave, f"get{variable.type}")([variable.valueReference])[0])

    def step(self, time: float, step: float) -> None:
        """One communication step [s]."""
        self._call(self.slave.doStep, time, step)

    def _call(self, function: Any, *arguments: Any) -> None:
        try:
            function(*arguments)
        except FMICallException as error:
            raise RuntimeError(f"status {error.status}: {'; '.join(self.messages)}") from None

    def run(
        self,
        inputs: dict[str, NDArray[np.float64]],
        outputs: list[str],
        step: float,
        first: int = 0,
        rows: int | None = None,
    ) -> NDArray[np.float64]:
        """Outputs, shape (rows + 1, outputs), for inputs held over each step."""
        count = rows if rows is not None else len(next(iter(inputs.values())))
        table = [[self.get(name) for name in outputs]]
        for k in range(first, first + count):
            self.set(**{name: float(column[k]) for name, column in inputs.items()})
            self.step(k * step, step)
            table.append([self.get(name) for name in outputs])
        return np.array(table)

    def address(self, name: str) -> int:
        """Address of an FMI function, as the C master takes it."""
        pointer = ctypes.cast(getattr(self.slave.dll, name), ctypes.c_void_p)
        assert pointer.value is not None
        return pointer.value

    def close(self) -> None:
        """Free the instance."""
        self.slave.freeInstance()


@contextmanager
def unpacked_fmu(path: Path) -> Iterator[Path]:
    """Folder of an unpacked FMU, removed afterwards."""
    folder = Path(extract(str(path)))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
