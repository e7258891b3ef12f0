"""The twin's own encoder counts, and the values of its parameters that leave none."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.problem import EncoderCounts
from gmfbo.diagnosis.comparison.starting.fixed_parameters import changeable, slightly_changed
from gmfbo.diagnosis.runs.quantum import resolution
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.job import ValueType
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.uncertain import Uncertain
from gmfbo.sources.twin_file.entries import OutputEntry

Array = NDArray[np.float64]

_UNLIKE = 0.1  # by which the power of the parameter in a count may differ from 1 or -1
_FINER, _FEWEST = 1000.0, 10.0  # counts in the place of one, and how many would do


def encoder_counts(case: Case) -> EncoderCounts | None:
    """How to simulate the twin without the counts of its encoders; None where that is not known.

    Two runs of one axis round otherwise, and the controller answers: what an encoder rounds away is
    noise. A simulation with counts holds noise of its own, which any small change shuffles. The
    parameter that sets the counts of an output is the one to which they are proportional, or
    inversely. All outputs of the FMU are read, those too that nobody recorded: the encoder of a
    motor behind a gear shuffles the command as well.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    """
    if case.simulations.tracking is not None:
        return None
    with _every_output(case.twin) as twin:
        runs = _Runs(twin, _most_moving(case))
        if not runs.counts:
            return None
        values, without = dict[str, float](), set[str]()
        for one in changeable(case.twin, (), also_certain=True):
            power = runs.power(one)
            if power == 0:
                continue
            finer = {one.name: _times(twin, one, power)}
            if fine := runs.without(finer):
                values |= finer
                without |= fine
    if not values or not all(run.finite for run in case.simulations.run([Point(values)])[0]):
        return None
    signal = case.rig.position
    return EncoderCounts(values, runs.counts[signal] if signal in without else 0.0)


def _every_output(twin: FmuTwin) -> FmuTwin:
    """The same twin, all real outputs of which are read."""
    known = {entry.variable for entry in twin.file.outputs.values()}
    added = {
        name: OutputEntry(variable=name)
        for name, bound in twin.binding.variables.items()
        if bound.variable.causality == "output"
        and bound.variable.value_type is ValueType.REAL
        and name not in known | twin.file.inputs.keys()
    }
    outputs = {**twin.file.outputs, **added}
    return twin.with_file(twin.file.model_copy(update={"outputs": outputs}))


def _most_moving(case: Case) -> Recording:
    values = [sum(np.unique(signal).size for signal in run.signals) for run in case.nominal]
    return case.simulations.records[int(np.argmax(values))].plan.recording


def _times(twin: FmuTwin, one: Uncertain, power: int) -> float:
    """[FMU's unit] Value with a thousand times the counts, or as many as the FMU allows."""
    value = one.nominal * _FINER**-power
    variable = twin.binding.parameters[one.name].variable
    if variable.minimum is not None:
        value = max(value, variable.minimum)
    return value if variable.maximum is None else min(value, variable.maximum)


class _Runs:
    """Runs of one recording by a twin whose outputs are all read.

    Attributes
    ----------
    counts : dict of str to float
        [SI unit] Quantum of each output that has one, as the twin is.
    """

    def __init__(self, twin: FmuTwin, recording: Recording) -> None:
        self._twin, self._recording = twin, recording
        self._before = self._columns({})
        self.counts = _quanta(self._before)

    def power(self, one: Uncertain) -> int:
        """Power of a parameter, 1 or -1, in the counts of an output; 0 of others."""
        value = slightly_changed(one)
        columns = self._columns({one.name: value})
        after = _quanta({name: columns[name] for name in self.counts if name in columns})
        for name, quantum in after.items():
            power = np.log(quantum / self.counts[name]) / np.log(value / one.nominal)
            if abs(abs(power) - 1.0) <= _UNLIKE:
                return round(float(power))
        return 0

    def without(self, values: Mapping[str, float]) -> set[str]:
        """Outputs that count no more at these values, of an axis that is what it was."""
        found, fine = set[str](), self._columns(values)
        for name, quantum in self.counts.items():
            if name not in fine:
                continue
            moved = float(np.sqrt(np.mean((fine[name] - self._before[name]) ** 2)))
            if resolution(fine[name]) * _FEWEST < quantum and moved < quantum:
                found.add(name)
        return found

    def _columns(self, values: Mapping[str, float]) -> dict[str, Array]:
        """All outputs; none where the twin does not get through the recording."""
        run = self._twin.run({}, self._recording, parameters=dict(values))
        return dict(run.signals) if run.status == "ok" else {}


def _quanta(columns: Mapping[str, Array]) -> dict[str, float]:
    found = {name: resolution(column) for name, column in columns.items()}
    return {name: quantum for name, quantum in found.items() if quantum > 0.0}
