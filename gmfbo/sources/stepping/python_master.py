"""The C master's loop in Python, about four times slower, for other machines.

Calls, their order and grouping are those of `fmu_build/master/master.c`, so that results agree to
the bit.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo.sources.fmu_file.job import ArrayElement, Job, ValueType
from gmfbo.sources.stepping.fmi2 import FmuCallError, Instance
from gmfbo.sources.stepping.interface import Values, crossing
from gmfbo.sources.stepping.stop import LoopStage, Stop


@dataclass
class _Group:
    """Variables of one FMU and one type that are set, or read, by one call."""

    type: ValueType
    values: dict[int, float] = field(default_factory=dict)

    def read(self, instance: Instance) -> int:
        """Read all values; returns the number of warnings."""
        status = 0
        scalars = [r for r in self.values if not ArrayElement.of(r)]
        if scalars:
            raw = instance.interface.room(self.type, len(scalars))
            status = instance.get_values(self.type, _references(scalars), raw)
            self.values.update(zip(scalars, map(float, raw), strict=True))
        for array, elements in self._arrays().items():
            raw = instance.interface.room(self.type, elements[0].size)
            status += instance.get_values(self.type, _references([array]), raw)
            self.values.update({e.packed: float(raw[e.place]) for e in elements})
        return status

    def write(self, instance: Instance) -> int:
        """Set all values; returns the number of warnings."""
        status = 0
        scalars = [r for r in self.values if not ArrayElement.of(r)]
        if scalars:
            raw = instance.interface.room(self.type, len(scalars))
            raw[:] = [crossing(self.values[r], self.type) for r in scalars]
            status = instance.set_values(self.type, _references(scalars), raw)
        for array, elements in self._arrays().items():
            raw = instance.interface.room(self.type, elements[0].size)
            if len(elements) < elements[0].size:  # the others keep their values
                status += instance.get_values(self.type, _references([array]), raw)
            for element in elements:
                raw[element.place] = crossing(self.values[element.packed], self.type)
            status += instance.set_values(self.type, _references([array]), raw)
        return status

    def _arrays(self) -> dict[int, list[ArrayElement]]:
        """Elements by the value references of their arrays."""
        arrays: dict[int, list[ArrayElement]] = {}
        for reference in self.values:
            element = ArrayElement.of(reference)
            if element is not None:
                arrays.setdefault(element.reference, []).append(element)
        return arrays


def _references(references: Sequence[int]) -> Values:
    return (ctypes.c_uint * len(references))(*references)


class _Loop:
    def __init__(
        self,
        instances: Sequence[Instance],
        job: Job,
        u: NDArray[np.float64],
        s: NDArray[np.float64],
        y: NDArray[np.float64],
    ) -> None:
        self.instances, self.job, self.u, self.s, self.y = instances, job, u, s, y
        self.step, self.fmu, self.stage, self.warnings = -1, 0, LoopStage.NONE, 0
        count = range(len(instances))
        self.set = [{t: _Group(t) for t in ValueType} for _ in count]
        self.get = [{t: _Group(t) for t in ValueType} for _ in count]
        for port in job.inputs:
            self.set[port.fmu][ValueType(port.type)].values[port.reference] = 0.0
        for wire in job.wires:
            self.set[wire.to_fmu][ValueType(wire.to_type)].values[wire.to_reference] = 0.0
            self.get[wire.from_fmu][ValueType(wire.from_type)].values[wire.from_reference] = 0.0
        for port in job.outputs:
            self.get[port.fmu][ValueType(port.type)].values[port.reference] = 0.0

    def advance(self) -> bool:
        """One communication step of all FMUs and the row after it; step -1 only reads."""
        for fmu, instance in enumerate(self.instances):
            self.fmu = fmu
            if self.step >= 0:
                self.stage = LoopStage.SET
                self._set_schedules(instance)
                self._set_inputs(instance)
                self.stage = LoopStage.STEP
                time = self.job.start + self.step * self.job.step
                self.warnings += instance.step(time, self.job.step)
            self.stage = LoopStage.GET
            self._sum_warnings(group.read(instance) for group in self.get[self.fmu].values())
        for port in self.job.outputs:
            values = self.get[port.fmu][ValueType(port.type)].values
            self.y[self.step + 1, port.column] = values[port.reference]
        return self._all_finite()

    def stop(self, fmi_status: int = 0, *, stopped: bool = True) -> Stop:
        return Stop(stopped, self.fmu, self.stage, self.step, fmi_status, self.warnings)

    def _set_schedules(self, instance: Instance) -> None:
        for port in self.job.schedules:
            column = self.s[:, port.column]
            changed = self.step == 0 or column[self.step] != column[self.step - 1]
            if port.fmu == self.fmu and changed:
                group = _Group(ValueType(port.type), {port.reference: float(column[self.step])})
                self.warnings += group.write(instance)

    def _set_inputs(self, instance: Instance) -> None:
        groups = self.set[self.fmu]
        for group in groups.values():
            group.values = dict.fromkeys(group.values, 0.0)
        for port in self.job.inputs:
            if port.fmu == self.fmu:
                values = groups[ValueType(port.type)].values
                values[port.reference] += float(self.u[self.step, port.column])
        for wire in self.job.wires:
            if wire.to_fmu == self.fmu:
                source = self.get[wire.from_fmu][ValueType(wire.from_type)].values
                values = groups[ValueType(wire.to_type)].values
                values[wire.to_reference] += wire.scale * source[wire.from_reference]
        self._sum_warnings(group.write(instance) for group in groups.values())

    def _sum_warnings(self, statuses: Iterable[int]) -> None:
        for status in statuses:
            self.warnings += status

    def _all_finite(self) -> bool:
        for fmu, groups in enumerate(self.get):
            for real in (group for kind, group in groups.items() if kind.is_real):
                if not all(map(math.isfinite, real.values.values())):
                    self.fmu, self.stage = fmu, LoopStage.NOT_FINITE
                    return False
        return True


def step_in_python(
    instances: Sequence[Instance],
    job: Job,
    u: NDArray[np.float64],
    s: NDArray[np.float64],
    y: NDArray[np.float64],
) -> Stop:
    """Step initialised FMUs through a whole run; see `gmfbo.sources.stepping.master.step_all`."""
    loop = _Loop(instances, job, u, s, y)
    try:
        while loop.advance():
            if loop.step + 1 >= job.steps:
                return Stop(warnings=loop.warnings)
            loop.step += 1
    except FmuCallError as error:
        loop.stage = getattr(error, "loop_stage", loop.stage)
        return loop.stop(error.status)
    return loop.stop()
