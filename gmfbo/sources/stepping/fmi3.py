"""An FMI 3.0 FMU's library and its instances; the rest is as in `fmi2`.

Event mode is not used: the FMU handles its events itself, as instantiation tells it to.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import fmpy.fmi1
import fmpy.fmi3

from gmfbo.sources.fmu_file.job import Stage, ValueType
from gmfbo.sources.fmu_file.unpacked_fmu import UnpackedFmu
from gmfbo.sources.stepping.fmi2 import ABSENT, ERROR, FmuCallError, Instance, LoadedFmu
from gmfbo.sources.stepping.interface import FMI3, Values
from gmfbo.sources.stepping.stop import LoopStage

_DISCARD = 2


class StepDemand(FmuCallError):
    """A step was made, and the FMU asks for something that a fixed-step master cannot do.

    Attributes
    ----------
    loop_stage : LoopStage
        `EVENT` or `ENDED`.
    """

    def __init__(self, loop_stage: LoopStage) -> None:
        super().__init__(loop_stage.name, Stage.STEP, _DISCARD)
        self.loop_stage = loop_stage


class FMU3TolerantSlave(fmpy.fmi3.FMU3Slave):  # type: ignore[misc]  # fmpy is untyped
    """A slave whose library may have another name, and lack optional functions.

    fmpy tells the FMI version by the first letters of the class name.
    """

    def __init__(self, **arguments: Any) -> None:
        # fmpy's class derives the library's path from the identifier.
        fmpy.fmi1._FMU.__init__(self, **arguments)

    def _loadFunctions(self) -> None:
        self.absent = {
            name for name in dir(self) if name.startswith("fmi3") and not hasattr(self.dll, name)
        }
        for name in self.absent:
            setattr(self.dll, name, ABSENT)
        super()._loadFunctions()


class LoadedFmu3(LoadedFmu):
    """The library of one FMI 3.0 FMU; see `LoadedFmu`."""

    interface = FMI3
    slave_class = FMU3TolerantSlave
    required = (
        "fmi3InstantiateCoSimulation",
        "fmi3FreeInstance",
        "fmi3EnterInitializationMode",
        "fmi3ExitInitializationMode",
        "fmi3SetFloat64",
        "fmi3GetFloat64",
        "fmi3DoStep",
    )

    def __init__(self, unpacked: UnpackedFmu) -> None:
        super().__init__(unpacked)
        self._resources = str(Path(unpacked.folder) / "resources") + os.sep
        log = self._log
        self._note = fmpy.fmi3.fmi3LogMessageCallback(
            lambda environment, status, category, message: log.note(status, message)
        )
        self._no_update = fmpy.fmi3.fmi3IntermediateUpdateCallback()

    def instantiate(self) -> Instance:
        """Make a new instance that handles its events itself.

        Raises
        ------
        FmuCallError
            The FMU refused.
        """
        self._log.lines.clear()
        component = self._slave.fmi3InstantiateCoSimulation(
            self._slave.instanceName.encode(),
            self._slave.guid.encode(),
            os.fsencode(self._resources),
            *(False, False, False, False),  # visible, logging, event mode, early return
            *((ctypes.c_uint * 0)(), 0),
            *(None, self._note, self._no_update),
        )
        if not component:
            refused = self.refusal("fmi3InstantiateCoSimulation", None)
            raise FmuCallError(refused, Stage.INSTANTIATE, ERROR)
        return Instance3(self, self._slave, ctypes.c_void_p(component))


class Instance3(Instance):
    """One instance of an FMI 3.0 FMU."""

    interface = FMI3

    def has_ended(self) -> bool:
        """False: in FMI 3.0 the step itself reports an ended simulation."""
        return False

    def set_values(
        self, kind: ValueType, references: Values, values: Values, stage: Stage = Stage.STEP
    ) -> int:
        """Set values of one type; FMI 3.0 counts values and variables separately."""
        sizes = len(references), len(values)
        return self.call(FMI3.setter(kind), stage, references, sizes[0], values, sizes[1])

    def get_values(self, kind: ValueType, references: Values, values: Values) -> int:
        """Read values of one type; FMI 3.0 counts values and variables separately."""
        sizes = len(references), len(values)
        return self.call(FMI3.getter(kind), Stage.STEP, references, sizes[0], values, sizes[1])

    def step(self, time: float, step: float) -> int:
        """Make one communication step, without event mode and early return.

        Parameters
        ----------
        time : float
            [s] Communication point at which it begins.
        step : float
            [s] Its length.

        Raises
        ------
        FmuCallError
            The FMU refused.
        StepDemand
            The FMU asks for event mode, returned early, or ended the simulation.
        """
        event, terminate, early = ctypes.c_bool(), ctypes.c_bool(), ctypes.c_bool()
        last = ctypes.c_double(time + step)
        pointers = (*map(ctypes.byref, (event, terminate, early)), ctypes.byref(last))
        status = self.call(FMI3.do_step, Stage.STEP, time, step, True, *pointers)
        if terminate.value:
            raise StepDemand(LoopStage.ENDED)
        if event.value or early.value:
            raise StepDemand(LoopStage.EVENT)
        return status

    def free(self) -> None:
        """Free the instance; the library stays loaded."""
        self._slave.fmi3FreeInstance(self.component)

    def _set_texts(self, references: Any, values: Sequence[str]) -> None:
        raw = (ctypes.c_char_p * len(values))(*(value.encode() for value in values))
        count = len(values)
        self.call("fmi3SetString", Stage.INITIALISE, references, count, raw, count)

    def _enter(self, start: float, stop: float | None) -> None:
        announced = (False, 0.0) if stop is None else (True, stop)
        self.call("fmi3EnterInitializationMode", Stage.INITIALISE, False, 0.0, start, *announced)
        self.call("fmi3ExitInitializationMode", Stage.INITIALISE)
