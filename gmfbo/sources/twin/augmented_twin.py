"""A twin with physics wired to its ports, run along recordings."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording
from gmfbo.sources.binding.augmented_binding import AugmentedBinding, PhysicsInstance, augment
from gmfbo.sources.fmu_file.job import Job, Outcome, Port, Setting
from gmfbo.sources.twin.from_rest import settles_after
from gmfbo.sources.twin.parameter_values import run_parameters, starts_as_recorded
from gmfbo.sources.twin.response import Columns, Response
from gmfbo.sources.twin.run_plan import Experiment
from gmfbo.sources.twin.signals import to_si
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.worker.runner import InProcess, Order, Runner


@dataclass(frozen=True, eq=False)
class RunPlan:
    """A recording laid on the communication grid, ready to be simulated many times.

    Attributes
    ----------
    recording : Recording
        Recording that is followed.
    experiment : Experiment
        The recording on the grid.
    lead : int
        Communication steps under the first row before the recording begins.
    substeps : int
        Steps of physics and twin within each.
    inputs : ndarray, shape ((lead + rows - 1) * substeps, n_inputs)
        [FMU's units]
    schedules : ndarray, shape ((lead + rows - 1) * substeps, n_schedules)
        [FMU's units]
    """

    recording: Recording
    experiment: Experiment
    lead: int
    substeps: int
    inputs: NDArray[np.float64]
    schedules: NDArray[np.float64]

    @classmethod
    def after(
        cls, recording: Recording, experiment: Experiment, lead: int, substeps: int
    ) -> RunPlan:
        """Plan a run that holds the first row for some steps before the recording begins.

        Parameters
        ----------
        recording : Recording
            Recording that is followed.
        experiment : Experiment
            The recording on the grid.
        lead, substeps : int
            Communication steps under the first row; steps of physics and twin within each.
        """
        order = experiment.order(lead)
        columns = (np.repeat(rows, substeps, axis=0) for rows in (order.u, order.s))
        return cls(recording, experiment, lead, substeps, *columns)

    def led_by(self, lead: int) -> RunPlan:
        """The same after so many steps under the first row.

        Parameters
        ----------
        lead : int
            Communication steps; as many as now give the same object.
        """
        same = lead == self.lead
        return self if same else self.after(self.recording, self.experiment, lead, self.substeps)

    def straight(self, names: Collection[str]) -> RunPlan:
        """The same with some inputs drawn straight from row to row at the fine steps.

        Parameters
        ----------
        names : collection of str
            Of `[inputs]`; those that this recording does not drive are left out.
        """
        rows = self.inputs[:: self.substeps]
        after = np.concatenate([rows[1:], rows[-1:]])
        part = (np.arange(self.substeps) / self.substeps)[None, :, None]
        drawn = rows[:, None] + part * (after - rows)[:, None]
        chosen = [name in names for name in self.experiment.inputs]
        inputs = np.where(chosen, drawn.reshape(self.inputs.shape), self.inputs)
        return replace(self, inputs=inputs)

    @property
    def grid(self) -> NDArray[np.float64]:
        """[s] Communication points, shape (rows,)."""
        return self.experiment.grid

    def at(self, values: NDArray[np.float64], time: NDArray[np.float64]) -> NDArray[np.float64]:
        """A column on the grid at other times, shape (n,).

        Parameters
        ----------
        values : ndarray, shape (rows,)
            On the grid.
        time : ndarray, shape (n,)
            [s] Of the recording.
        """
        step = float(self.grid[1] - self.grid[0]) if self.grid.size > 1 else 1.0
        places = (time - self.grid[0]) / step
        rows = np.round(places).astype(int)
        if rows[-1] < self.grid.size and np.abs(places - rows).max() < 1e-3:
            exact: NDArray[np.float64] = values[rows]
            return exact
        return np.interp(time, self.grid, values)


class AugmentedTwin:
    """A twin with physics.fmu at its ports, stepped finely enough for both.

    Signals of [inputs] are sampled at the twin's communication step and held over the
    substeps, as they are when the exported FMU is stepped at that step.

    Parameters
    ----------
    twin : FmuTwin
        Gives parameters and isolation; its own worker is not used.
    substeps : int
        Steps of physics and twin within one communication step.
    isolated : bool
        Run in a worker process; False is for FMUs that are trusted.
    time_limit_s : float, optional
        [s] Wall-clock time that one simulation may take in the worker; else the twin file's, or
        10 s and 20 times the simulated time.
    sensor_included : bool
        Whether the state `position` is the reading, which contains the sensor port's signal.

    Raises
    ------
    FmuFileError
        An FMU cannot run on this machine.
    """

    def __init__(
        self,
        twin: FmuTwin,
        *,
        substeps: int = 10,
        isolated: bool = True,
        time_limit_s: float | None = None,
        sensor_included: bool = False,
    ) -> None:
        self.twin, self.substeps, self._sensor_included = twin, substeps, sensor_included
        self._augmented: AugmentedBinding = augment(twin.binding)
        self._isolated, self._time_limit_s = isolated, time_limit_s or twin.file.time_limit
        self._runner: Runner | None = None

    @property
    def step(self) -> float:
        """[s] Step of twin and physics."""
        return self.twin.step / self.substeps

    @property
    def ports(self) -> tuple[str, ...]:
        """Ports at which physics can act."""
        return tuple(port for physics in self._augmented.physics for port in physics.ports)

    @property
    def settings(self) -> dict[str, float]:
        """Settings of physics.fmu that follow from the twin file."""
        states = self.twin.file.states
        return {
            "settings.velocity_from_position": float("velocity" not in states),
            "settings.current_known": float("current" in states),
            "settings.load_torque_known": float("load_torque" in states),
            "settings.command_lateness": self.step if self._augmented.late else 0.0,
            "tracking.sensor_included": float(self._sensor_included),
            "settings.command_is_input": float(self._augmented.command_input is not None),
        }

    def plan(self, recording: Recording, parameters: Mapping[str, float]) -> RunPlan:
        """Plan a run along a recording, with the time that the twin needs to come to rest first.

        Parameters
        ----------
        recording : Recording
            Signals of [inputs] in SI, schedules, and parameters in force.
        parameters : mapping of str to float
            [FMU's unit] At which the twin settles.

        Raises
        ------
        RecordingError
            The recording cannot drive this twin.
        InputError
            A parameter is unknown or outside the FMU's bounds.
        """
        binding = self._augmented.binding
        override = {**self.twin.parameters, **parameters}
        chosen = run_parameters(binding, recording, override, {}, self.twin.texts)
        experiment = Experiment.prepare(
            binding, recording, chosen, self.twin.step, substeps=self.substeps
        )
        at_rest = not starts_as_recorded(binding, recording)
        lead = settles_after(self._started(), experiment) if at_rest else 0
        return RunPlan.after(recording, experiment, lead, self.substeps)

    def run(
        self,
        plan: RunPlan,
        parameters: Mapping[str, float],
        physics: Mapping[str, float] | None = None,
        *,
        excitation: Columns | None = None,
        measured: NDArray[np.float64] | None = None,
        held: Mapping[str, float] | None = None,
    ) -> Response:
        """Simulate along a recording.

        Parameters
        ----------
        plan : RunPlan
            The recording.
        parameters : mapping of str to float
            [FMU's unit] Of the twin.
        physics : mapping of str to float
            Of physics.fmu, such as `coulomb_friction.level`.
        excitation : mapping of str to ndarray, shape (rows,)
            [FMU's unit] Added to a port from each communication point on.
        measured : ndarray, shape (rows,)
            [FMU's unit] Position that the tracking loop follows, a cubic spline between rows.
        held : mapping of str to float
            [FMU's unit] FMU inputs that nothing drives, and the value of each for the whole run.

        Raises
        ------
        InputError
            A parameter is unknown or outside the FMU's bounds.
        """
        binding = self._augmented.binding
        override = {**self.twin.parameters, **parameters}
        chosen = run_parameters(binding, plan.recording, override, {}, self.twin.texts)
        experiment = replace(plan.experiment, parameters=chosen)
        coarse = experiment.order(plan.lead).job
        inputs, columns = self._driven(plan, excitation or {}, measured, held or {})
        outputs = self._outputs(len(coarse.outputs))
        job = Job(
            steps=coarse.steps * self.substeps,
            start=coarse.start,
            told_start=coarse.told_start,
            step=self.step,
            settings=(*coarse.settings, *self._physics_settings(physics or {})),
            inputs=(*self._through_physics(coarse.inputs, plan), *inputs),
            schedules=coarse.schedules,
            wires=(*coarse.wires, *self._augmented.wires),
            outputs=(*coarse.outputs, *outputs),
            texts=coarse.texts,
            stop=coarse.stop,
        )
        u = np.ascontiguousarray(np.column_stack([plan.inputs, *columns]))
        result = self._started().run(Order(job, u, plan.schedules))[0]
        return self._response(plan, result.outcome, result.y)

    def close(self) -> None:
        """End the worker and remove its files, unless the twin keeps it for another."""
        runner, self._runner = self._runner, None
        if runner is None:
            return
        if self.twin.kept is None or not self._shares_workers:
            runner.close()
        else:
            self.twin.kept.give(runner)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _started(self) -> Runner:
        if self._runner is None:
            kept = self.twin.kept if self._shares_workers else None
            if kept is not None and (runner := kept.take()) is not None:
                self._runner = runner
            elif self._isolated:
                from gmfbo.sources.worker.isolation import Isolated

                binding = self._augmented.binding
                self._runner = Isolated(binding, time_limit_s=self._time_limit_s)
            else:
                self._runner = InProcess(self._augmented.binding)
        return self._runner

    @property
    def _shares_workers(self) -> bool:
        return self._isolated and self._time_limit_s == self.twin.file.time_limit

    def _physics_settings(self, physics: Mapping[str, float]) -> list[Setting]:
        values = {**self.settings, **physics}
        return [
            instance.variables[name].setting(float(value))
            for instance in self._augmented.physics
            for name, value in values.items()
        ]

    def _driven(
        self,
        plan: RunPlan,
        excitation: Columns,
        measured: NDArray[np.float64] | None,
        held: Mapping[str, float],
    ) -> tuple[list[Port], list[NDArray[np.float64]]]:
        """Inputs beside the recorded ones, and their columns at the fine steps."""
        ports: list[Port] = []
        columns: list[NDArray[np.float64]] = []
        first = plan.inputs.shape[1]
        for name, values in excitation.items():
            owner = next(p for p in self._augmented.physics if name in p.ports)
            ports.append(owner.variables[f"port.{name}"].port(first + len(columns)))
            padded = np.concatenate([np.full(plan.lead, values[0]), values[:-1]])
            columns.append(np.repeat(padded, self.substeps))
        if measured is not None:
            rows = np.arange(len(plan.inputs)) / self.substeps - plan.lead
            column = _between_rows(measured, rows)
            for instance in self._augmented.physics:
                ports.append(instance.variables["tracking.measured"].port(first + len(columns)))
                columns.append(column)
        for name, value in held.items():
            ports.append(self._augmented.binding.variables[name].port(first + len(columns)))
            columns.append(np.full(len(plan.inputs), value))
        return ports, columns

    def _through_physics(self, inputs: tuple[Port, ...], plan: RunPlan) -> tuple[Port, ...]:
        """Route a recorded command through physics to its port."""
        name = self._augmented.command_input
        if name is None or name not in plan.experiment.inputs:
            return inputs
        owner = self._serves("command")
        assert owner is not None, "a command port has its physics"
        column = list(plan.experiment.inputs).index(name)
        through = owner.variables["port.command"].port(column)
        return tuple(through if port.column == column else port for port in inputs)

    def _outputs(self, first: int) -> list[Port]:
        binding = self._augmented.binding
        bound = [binding.variables[name] for name in binding.file.states.values()]
        for instance in self._augmented.physics:
            bound += [instance.variables[port] for port in instance.ports]
        if (torque := self._serves("torque")) is not None:
            bound.append(torque.variables["tracking.effort"])
        return [variable.port(first + column) for column, variable in enumerate(bound)]

    def _serves(self, port: str) -> PhysicsInstance | None:
        return next((p for p in self._augmented.physics if port in p.ports), None)

    def _response(self, plan: RunPlan, outcome: Outcome, y: NDArray[np.float64]) -> Response:
        binding = self._augmented.binding
        points = (plan.lead + np.arange(plan.grid.size)) * self.substeps
        after = np.minimum(points + 1, len(y) - 1)
        over = np.maximum(points[:, None] - np.arange(self.substeps), 0)
        held, new, mean = {}, {}, {}
        for column, (name, entry) in enumerate(binding.file.outputs.items()):
            variable = binding.variables[entry.variable].variable
            held[name] = to_si(variable, y[points, column])
            new[name] = to_si(variable, y[after, column])
            mean[name] = to_si(variable, y[over, column].mean(axis=1))
        column = len(binding.file.outputs)
        states = {}
        for state in binding.file.states:
            states[state] = y[points, column]
            column += 1
        ports = {}
        for port in self.ports:
            ports[port] = y[after, column]
            column += 1
        effort = np.zeros(points.size)
        if "torque" in ports:
            # The mean over each step moves the shaft; the value at its beginning would be biased.
            steps = y[1 + self.substeps * plan.lead :, column].reshape(-1, self.substeps)
            effort[:-1] = steps.mean(axis=1)
            effort[-1] = effort[-2]
        return Response(outcome, held, new, mean, states, ports, effort)


def _between_rows(measured: NDArray[np.float64], rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Recorded column at fractional rows, by a spline with the motion's slope at each row.

    Linear interpolation delays the velocity by half a step; to the tracking loop this looks like
    an inertia of its damping times half a step.
    """
    from scipy.interpolate import CubicSpline

    inside = np.clip(rows, 0.0, measured.size - 1.0)
    if measured.size < 4 or not np.all(np.isfinite(measured)):
        return np.interp(inside, np.arange(measured.size), measured)
    spline: NDArray[np.float64] = CubicSpline(np.arange(measured.size), measured)(inside)
    return spline
