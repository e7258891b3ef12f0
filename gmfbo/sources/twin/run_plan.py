"""Run plan: from a recording to a job, and from outputs to a trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.fmu_file.job import Job, Port
from gmfbo.sources.twin.parameter_values import RunParameters
from gmfbo.sources.twin.sampling import sample, steps_to_cover
from gmfbo.sources.twin.signals import as_logged, input_columns, to_fmu, to_si
from gmfbo.sources.twin_file.twin_file import TwinFile
from gmfbo.sources.worker.runner import Order, Result


@dataclass(frozen=True, eq=False)
class Experiment:
    """Inputs and parameters of one run on the communication grid.

    Attributes
    ----------
    binding : Binding
        The twin.
    parameters : RunParameters
        Parameters of the run.
    name : str
        Of the recording that is followed.
    step : float
        [s] Communication step.
    grid : ndarray, shape (rows,)
        [s] Communication points; the last has no step after it.
    inputs : mapping of str to ndarray, shape (rows,)
        Signals of [inputs] [SI].
    schedules : mapping of str to ndarray, shape (rows,)
        Parameters that change [FMU's unit].
    """

    binding: Binding
    parameters: RunParameters
    name: str
    step: float
    grid: NDArray[np.float64]
    inputs: Mapping[str, NDArray[np.float64]]
    schedules: Mapping[str, NDArray[np.float64]]

    @classmethod
    def prepare(
        cls,
        binding: Binding,
        recording: Recording,
        parameters: RunParameters,
        step: float,
        *,
        substeps: int = 1,
    ) -> Experiment:
        """Sample a recording on the communication grid.

        Parameters
        ----------
        binding : Binding
            The twin.
        recording : Recording
            Recording that is followed.
        parameters : RunParameters
            Parameters of the run.
        step : float
            [s] Communication step.
        substeps : int
            Steps of the FMUs within each.

        Raises
        ------
        RecordingError
            The recording cannot drive this twin, or takes more steps than [limits] allows.
        """
        steps = steps_to_cover(recording.time, step)
        _check_steps(binding, recording, steps, substeps)
        grid = recording.time[0] + np.arange(steps + 1) * step
        return cls(
            binding=binding,
            parameters=parameters,
            name=recording.name,
            step=step,
            grid=grid,
            inputs=input_columns(binding, recording, grid),
            schedules={
                name: sample(recording.time, column, grid, "hold", name)
                for name, column in parameters.schedules.items()
            },
        )

    def order(self, lead: int) -> Order:
        """Order of the run, after `lead` steps under the first row."""
        steps = self.grid.size - 1
        rows = np.concatenate([np.zeros(lead, dtype=int), np.arange(steps)])
        schedules = tuple(
            self.binding.variables[name].port(column) for column, name in enumerate(self.schedules)
        )
        return Order(
            self._job(lead + steps, -lead, schedules),
            np.ascontiguousarray(self._driven()[rows]),
            np.ascontiguousarray(_table(self.schedules, self.grid.size)[rows]),
        )

    def probe_at_start(self, steps: int) -> Order:
        """Order of some steps under the first row, from the first communication point."""
        return self._probe(steps, 0)

    def probe_before_start(self, steps: int) -> Order:
        """Order of some steps under the first row, up to the first communication point."""
        return self._probe(steps, -steps)

    def trajectory(self, result: Result, lead: int, seconds: float) -> Trajectory:
        """Make the trajectory of a run; one row of NaN where the run gave none.

        Parameters
        ----------
        result : Result
            How the run ended, and its outputs [FMU's units].
        lead : int
            Steps before the first communication point, which are dropped.
        seconds : float
            [s] Wall-clock time of the run.
        """
        outcome = result.outcome
        entries = self.binding.file.outputs
        rows = min(max(outcome.rows - lead, 0), self.grid.size)
        kept = result.y[lead : lead + rows] if rows else np.full((1, len(entries)), np.nan)
        signals = {}
        for column, (name, entry) in enumerate(entries.items()):
            variable = self.binding.variables[entry.variable].variable
            signals[name] = to_si(variable, as_logged(entry, kept[:, column]))
        signals |= {name: values[: len(kept)] for name, values in self.inputs.items()}
        stopped = None if outcome.status == "ok" else float(self.grid[len(kept) - 1])
        return Trajectory(
            time=self.grid[: len(kept)],
            signals=signals,
            units=self._units(),
            name=self.binding.file.name,
            parameters=self.parameters.in_force,
            schedules={name: values[: len(kept)] for name, values in self.schedules.items()},
            status=outcome.status,
            message=outcome.message,
            stopped_at=stopped,
            seconds=seconds,
        )

    def _probe(self, steps: int, first_row: int) -> Order:
        first = self._driven()[:1]
        return Order(
            self._job(steps, first_row, ()),
            np.ascontiguousarray(np.repeat(first, steps, axis=0)),
            np.empty((steps, 0)),
        )

    def _job(self, steps: int, first_row: int, schedules: tuple[Port, ...]) -> Job:
        file, variables = self.binding.file, self.binding.variables
        recorded = float(self.grid[0])
        start = self.binding.start_time(recorded) + first_row * self.step
        return Job(
            steps=steps,
            start=start,
            told_start=recorded + first_row * self.step,
            step=self.step,
            settings=self.parameters.settings,
            texts=self.parameters.texts,
            stop=announced_stop(file, start, steps, self.step),
            inputs=tuple(
                variables[file.inputs[name].variable].port(column)
                for column, name in enumerate(self.inputs)
            ),
            schedules=schedules,
            wires=self.binding.wires,
            outputs=tuple(
                variables[entry.variable].port(column)
                for column, entry in enumerate(file.outputs.values())
            ),
        )

    def _driven(self) -> NDArray[np.float64]:
        """Inputs in the FMU's units, shape (rows, n_inputs)."""
        file, variables = self.binding.file, self.binding.variables
        return _table(
            {
                name: to_fmu(variables[file.inputs[name].variable].variable, values)
                for name, values in self.inputs.items()
            },
            self.grid.size,
        )

    def _units(self) -> dict[str, str]:
        file, variables = self.binding.file, self.binding.variables
        entries = {**file.inputs, **file.outputs}
        units = {name: variables[e.variable].variable.si_unit for name, e in entries.items()}
        return {
            name: unit
            for name, unit in units.items()
            if unit and (name in file.outputs or name in self.inputs)
        }


def _check_steps(binding: Binding, recording: Recording, steps: int, substeps: int) -> None:
    """Refuse a run that [limits] excludes, before its arrays take memory."""
    most = binding.file.limits.steps
    if steps * substeps <= most:
        return
    each = "" if substeps == 1 else f" of {substeps} substeps"
    raise RecordingError(
        f"{recording.name or 'recording'}: expected at most {most:,} steps of the twin, got "
        f"{steps:,}{each} for {recording.duration:,.9g} s; is its time in another unit? else cut "
        "the recording, or raise steps in [limits] of the twin file"
    )


def announced_stop(file: TwinFile, start: float, steps: int, step: float) -> float | None:
    """[s] Stop time that the twin file has announced to the FMUs; None for none.

    Parameters
    ----------
    file : TwinFile
        The twin file.
    start : float
        [s] FMU time of the first communication point.
    steps : int
        Communication steps.
    step : float
        [s] Communication step. The end of the run and one step are announced, since many FMUs
        refuse a step that ends at their stop time within round-off.
    """
    if file.stop_time is True:
        return start + (steps + 1) * step
    return None if file.stop_time is False else float(file.stop_time)


def _table(columns: Mapping[str, NDArray[np.float64]], rows: int) -> NDArray[np.float64]:
    return np.column_stack(list(columns.values())) if columns else np.empty((rows, 0))
