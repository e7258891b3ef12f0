"""From a twin and recordings to a case: measured, aligned and refitted."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.budget import NoiseLevel, fast_power, noise_level, noise_levels, pooled
from gmfbo.diagnosis.case import Budget, Case
from gmfbo.diagnosis.fitting import Fitted, fit
from gmfbo.diagnosis.hypothesis import Hypothesis, Setting, Uncertain
from gmfbo.diagnosis.misfit import Misfit
from gmfbo.diagnosis.nuisances import Direction
from gmfbo.diagnosis.preparation import (
    Rig,
    covariances,
    describe_rig,
    noise_runs,
    noise_squares,
    nuisance_directions,
    own_variances,
    white_variances,
    whiteners,
    windows_of,
)
from gmfbo.diagnosis.ranges import (
    measure_ranges,
    probe_torque,
    tracking_loop,
    untracked,
)
from gmfbo.diagnosis.records import Record, ScoredSignal, resolution, scored_record
from gmfbo.diagnosis.simulations import Point, Reading, Simulated, Simulations, require_run
from gmfbo.diagnosis.whitening import Window
from gmfbo.errors import RecordingError
from gmfbo.physics import Excitation
from gmfbo.recordings.recording import Recording
from gmfbo.sources.augmented import AugmentedTwin
from gmfbo.sources.twin import FmuTwin

FINEST_STEP_S = 2e-4
"""[s] Step of twin and physics: at it, effects on commands lose less than 1 % to the hold."""

_MOST_SUBSTEPS = 10
_READ_BACK = 0.5  # of what is added at the sensor port, which a reading shows a step later
_STEP_CHANGE = 0.01  # of a signal's range, by which a finer communication step may change it
_JUMP_SHARE = 0.7  # of a signal's changes, which a command makes at its sampling instants


def open_case(
    twin: FmuTwin,
    recordings: Sequence[Recording],
    *,
    seed: int,
    jobs: int | None,
    new_rows: frozenset[str] | None = None,
    on_run: Callable[[], None] = lambda: None,
) -> Case:
    """Run the twin along its recordings, measure the noise, refit what is uncertain.

    Parameters
    ----------
    twin : FmuTwin
        The user's.
    recordings : sequence of Recording
        Runs of the real axis.
    seed : int
        Of the noise runs.
    jobs : int or None
        Simulators; None for one a processor.
    new_rows : frozenset of str, optional
        Outputs of which the logger stores the value just computed; found out unless given.
    on_run : callable
        Called after each run.

    Raises
    ------
    RecordingError
        There is nothing to compare.
    SimulationError
        The twin as it is cannot follow a recording.
    """
    if not recordings:
        raise RecordingError("expected at least one recording, got none")
    substeps = int(np.clip(round(twin.step / FINEST_STEP_S), 1, _MOST_SUBSTEPS))
    notes: list[str] = []
    opening = _Opening(twin, recordings, seed, jobs or _processors(), notes, on_run)
    opening.new_rows = new_rows
    return opening.case(substeps)


def open_unseen(
    case: Case, recordings: Sequence[Recording], *, seed: int, jobs: int | None
) -> Case:
    """Open other recordings of the same axis, as a case was opened; nothing is fitted to them.

    Parameters
    ----------
    case : Case
        Whose twin, alignment and refitted parameters hold.
    recordings : sequence of Recording
        Runs that are only scored.
    seed : int
        Of the noise runs.
    jobs : int or None
        Simulators; None for one a processor.

    Raises
    ------
    RecordingError
        There is nothing to compare.
    SimulationError
        The twin as it is cannot follow a recording.
    """
    opening = _Opening(case.twin, recordings, seed, jobs or _processors(), case.notes)
    return opening.unseen(case)


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _Opening:
    """The steps from files to a refitted twin, in order."""

    def __init__(
        self,
        twin: FmuTwin,
        recordings: Sequence[Recording],
        seed: int,
        jobs: int,
        notes: list[str],
        on_run: Callable[[], None] = lambda: None,
    ) -> None:
        self.twin, self.recordings, self.jobs, self.on_run = twin, recordings, jobs, on_run
        self.rng = np.random.default_rng(seed)
        self.notes = notes
        self.new_rows: frozenset[str] | None = None
        self.sensor_included = False

    def case(self, substeps: int) -> Case:
        if substeps > 1 and not self._steps_finely(substeps):
            substeps = 1
            self.notes.append(
                "the twin gives other results, or none, at a finer communication step: physics was "
                f"stepped at {self.twin.step:g} s, at which effects on the command are less exact"
            )
        self.sensor_included = self._reads_back(substeps)
        simulations = self._simulations(substeps)
        try:
            return self._case(simulations, substeps)
        except BaseException:
            simulations.close()
            raise

    def _steps_finely(self, substeps: int) -> bool:
        """Whether a finer communication step leaves the twin's outputs as they are.

        Some FMUs refuse it; in some the controller computes once a step, whatever its length.
        """
        responses = []
        for count in (1, substeps):
            with AugmentedTwin(self.twin, substeps=count) as simulator:
                plan = simulator.plan(self.recordings[0], {})
                responses.append(simulator.run(plan, {}))
        whole, fine = responses
        if whole.outcome.status != "ok":
            return True  # it is told to the user where the finer run fails as well
        if fine.outcome.status != "ok":
            return False
        return all(
            float(np.sqrt(np.mean((fine.held[name] - column) ** 2)))
            <= _STEP_CHANGE * max(float(np.ptp(column)), 1e-300)
            for name, column in whole.held.items()
        )

    def _reads_back(self, substeps: int) -> bool:
        """Whether the state `position` holds what is added at the sensor port at once."""
        with AugmentedTwin(self.twin, substeps=substeps) as simulator:
            if "sensor" not in simulator.ports or "position" not in self.twin.file.states:
                return False
            plan = simulator.plan(self.recordings[0], {})
            plain = simulator.run(plan, {})
            position = plain.states["position"]
            if plain.outcome.status != "ok" or position.size < 2:
                return False
            size = max(1e-3 * float(np.ptp(position)), 1e-6)
            added = simulator.run(plan, {}, excitation={"sensor": np.full(position.size, size)})
            moved = float(added.states["position"][1] - position[1])
        return bool(moved > _READ_BACK * size)

    def unseen(self, like: Case) -> Case:
        self.sensor_included = like.simulations.settings["tracking.sensor_included"] > 0.0
        simulations = self._simulations(like.substeps)
        try:
            return self._unseen(simulations, like)
        except BaseException:
            simulations.close()
            raise

    def _unseen(self, simulations: Simulations, like: Case) -> Case:
        if like.simulations.tracking is not None:
            settings = like.simulations.tracking.settings
            self._track(simulations, like.rig, None)
            assert simulations.tracking is not None, "it was set a moment ago"
            simulations.tracking = replace(simulations.tracking, settings=settings)
        simulations.new_rows = like.simulations.new_rows
        simulations.reading = like.simulations.reading
        simulations.encoder = like.simulations.encoder
        nominal = simulations.run([Point()])[0]
        require_run(nominal, f"{self.twin.name}: the twin as it is cannot follow the recordings")
        noise = noise_levels(simulations.records, nominal)
        excitation = like.setting.excitation
        windows = windows_of(simulations.records, excitation.loop_time)
        empty: list[list[Direction]] = [[] for _ in simulations.records]
        own = [
            white_variances(r, levels) for r, levels in zip(simulations.records, noise, strict=True)
        ]
        spectra = covariances(windows, simulations.records, like.rig, own, empty)
        misfit = Misfit(simulations, whiteners(windows, spectra, empty))
        hypothesis = Hypothesis(like.setting)
        base = fit(misfit, hypothesis, like.base.parameters, parallel=True, iterations=1)
        assert base is not None, "the nominal twin was simulated a moment ago"
        ratio = excitation.torque / excitation.command
        budget = self._budget(simulations, windows, like.rig, base, ratio)
        misfit = Misfit(simulations, budget.whiteners())
        return Case(
            self.twin,
            simulations,
            like.substeps,
            like.rig,
            nominal,
            self._pooled(simulations, like.rig, noise),
            budget,
            misfit,
            like.setting,
            base.measured_by(misfit),
            self.notes,
        )

    def _simulations(self, substeps: int) -> Simulations:
        def open_twin() -> AugmentedTwin:
            return AugmentedTwin(self.twin, substeps=substeps, sensor_included=self.sensor_included)

        with open_twin() as first:
            records = self._records(first)
        simulations = Simulations(open_twin, records, self.jobs)
        simulations.on_run = self.on_run
        return simulations

    def _records(self, simulator: AugmentedTwin) -> list[Record]:
        outputs = list(self.twin.file.outputs)
        warmup = self.twin.file.warmup or 0.0
        return [
            scored_record(recording, simulator.plan(recording, {}), outputs, warmup)
            for recording in self.recordings
        ]

    def _case(self, simulations: Simulations, substeps: int) -> Case:
        nominal = simulations.run([Point()])[0]
        require_run(nominal, f"{self.twin.name}: the twin as it is cannot follow the recordings")
        rig = describe_rig(self.twin.binding, simulations.records)
        simulations.reading = self._reading(rig)
        if rig.position is not None:
            simulations.encoder = Reading(rig.position, rig.position_to_si)
        stiffness = None
        if "torque" in nominal[0].response.ports:
            guess = self._torque_guess(nominal)
            stiffness = probe_torque(simulations, Point(), nominal, guess)
            if stiffness.is_open and rig.position is not None:
                self._track(simulations, rig, stiffness.inertia)
                nominal = simulations.run([Point()])[0]
                require_run(nominal, f"{self.twin.name}: the twin cannot be held on its recordings")
        self._choose_rows(simulations, nominal)
        nominal = self._reread(simulations, nominal)
        noise = noise_levels(simulations.records, nominal)
        ratio = 1.0 if stiffness is None else stiffness.per_command
        if not np.isfinite(ratio):
            ratio = 1.0  # torque and command taken to be in one unit
        loop_time = 0.05
        if stiffness is not None and np.isfinite(stiffness.loop_time):
            loop_time = max(stiffness.loop_time, 2.0 * self.twin.step)
        excitation = self._excitation(simulations, nominal, rig, noise, ratio, loop_time, substeps)
        role = self.twin.file.roles.get("inertia")
        least = self.twin.binding.variables[role].variable.minimum if role else None
        setting = Setting(self._uncertain(), excitation, role, least or 0.0)
        windows = windows_of(simulations.records, loop_time, nominal, rig.positions)
        misfit, base = self._first_fit(simulations, windows, rig, noise, setting, nominal)
        budget = self._budget(simulations, windows, rig, base, ratio)
        misfit = Misfit(simulations, budget.whiteners())
        refitted = fit(misfit, Hypothesis(setting), base.parameters, parallel=True, iterations=4)
        assert refitted is not None, "it was simulated at these values a moment ago"
        levels = noise_levels(simulations.records, base.simulated)
        return Case(
            self.twin,
            simulations,
            substeps,
            rig,
            nominal,
            self._pooled(simulations, rig, levels),
            budget,
            misfit,
            setting,
            refitted,
            self.notes,
        )

    # ---- steps -----------------------------------------------------------------------------

    def _torque_guess(self, nominal: Sequence[Simulated]) -> float:
        """A torque that the axis feels, to begin probing with."""
        states = nominal[0].response.states
        if "command" in states:
            return max(0.05 * float(np.abs(states["command"]).max()), 1e-9)
        inertia = self._inertia()
        if inertia is not None and "position" in states:
            return max(10.0 * inertia * float(np.ptp(states["position"])), 1e-9)
        return 1.0

    def _reading(self, rig: Rig) -> Reading | None:
        """The recorded position, where the sensor port is the end of a wire from that output."""
        file, port = self.twin.file, self.twin.file.ports.get("sensor")
        if rig.position is None or port is None or port not in file.wires:
            return None
        if file.wires[port] != file.outputs[rig.position].variable:
            return None
        return Reading(rig.position, rig.position_to_si)

    def _inertia(self) -> float | None:
        role = self.twin.file.roles.get("inertia")
        if role is None:
            return None
        return float(self.twin.parameters.get(role, self.twin.binding.nominal(role)))

    def _track(self, simulations: Simulations, rig: Rig, inertia: float | None) -> None:
        """Keep an open-loop twin near its recordings, and score what the loop leaves."""
        own = self._inertia() or inertia or 1.0
        measured = []
        records = []
        for record in simulations.records:
            column = record.plan.recording.signal(rig.position or "")
            known = np.isfinite(column)
            grid = record.plan.grid
            on_grid = np.interp(grid, record.plan.recording.time[known], column[known])
            measured.append(on_grid / rig.position_to_si)
            fast = untracked(on_grid, grid)
            records.append(
                replace(
                    record,
                    signals=tuple(
                        replace(s, driving=np.interp(s.time, grid, fast))
                        if s.name in rig.positions
                        else s
                        for s in record.signals
                    ),
                )
            )
        simulations.tracking = tracking_loop(own, measured)
        simulations.replace_records(records)
        self.notes.append(
            "the twin is an open-loop plant: a slow tracking loop kept it near each recording, "
            "and what that leaves was scored"
        )

    def _choose_rows(self, simulations: Simulations, nominal: Sequence[Simulated]) -> None:
        """Tell for each signal whether the logger stores the held command or the new one."""
        if self.new_rows is not None:
            simulations.new_rows = self.new_rows
            return
        chosen = set()
        for name, entry in self.twin.file.outputs.items():
            if entry.logged == "new" or (
                entry.logged == "unknown"
                and not _written_by_gmfbo(self.recordings)
                and self._new_fits_better(simulations, nominal, name)
            ):
                chosen.add(name)
        simulations.new_rows = frozenset(chosen)

    def _new_fits_better(
        self, simulations: Simulations, nominal: Sequence[Simulated], name: str
    ) -> bool:
        """Compare the fast parts: a sample's shift shows there, parameters do not."""
        squares = {"held": 0.0, "new": 0.0}
        for k, (record, run) in enumerate(zip(simulations.records, nominal, strict=True)):
            for i, signal in enumerate(record.signals):
                if signal.name != name:
                    continue
                held = simulations.read(run.response, k)[i]
                new = simulations.read(replace(run.response, held=run.response.new), k)[i]
                if not _jumps(held, new):
                    return False  # a measurement moves on slowly: it is not held anywhere
                for key, values in (("held", held), ("new", new)):
                    squares[key] += float(np.sum(np.diff(signal.values - values) ** 2))
        return squares["new"] < squares["held"]

    def _reread(self, simulations: Simulations, simulated: Sequence[Simulated]) -> list[Simulated]:
        return [
            replace(run, quiet=simulations.read(run.response, k)) for k, run in enumerate(simulated)
        ]

    def _excitation(
        self,
        simulations: Simulations,
        nominal: Sequence[Simulated],
        rig: Rig,
        noise: list[dict[str, NoiseLevel]],
        ratio: float,
        loop_time: float,
        substeps: int,
    ) -> Excitation:
        commands = [
            np.abs(r.response.states["command"]).max()
            for r in nominal
            if "command" in r.response.states
        ]
        torque = ratio * float(max(commands)) if commands else 0.0
        if simulations.tracking is not None or torque <= 0.0:
            torque = self._moving_torque(simulations, nominal)
        resolution = self._position_noise(simulations, rig, noise) or 0.0
        return measure_ranges(
            simulations.records,
            nominal,
            torque=torque,
            step=self.twin.step / substeps,
            loop_time=loop_time,
            resolution=resolution,
            inertia=self._inertia(),
            angular="m" not in {self._position_unit(), ""},
        )

    def _pooled(
        self, simulations: Simulations, rig: Rig, levels: list[dict[str, NoiseLevel]]
    ) -> dict[str, NoiseLevel]:
        names = dict.fromkeys(name for level in levels for name in level)
        found = {name: level for name in names if (level := pooled(levels, name)) is not None}
        if rig.position is not None and rig.position not in found:
            own = self._position_noise(simulations, rig, levels) or 0.0
            total = own * rig.position_to_si
            found[rig.position] = NoiseLevel(total, total)
        return found

    def _position_noise(
        self, simulations: Simulations, rig: Rig, noise: list[dict[str, NoiseLevel]]
    ) -> float | None:
        """[FMU's unit] Of the recorded position; None where there is none."""
        if rig.position is None:
            return None
        level = pooled(noise, rig.position)
        if level is not None:
            return level.total / rig.position_to_si
        found = []
        for record in simulations.records:
            column = record.plan.recording.signal(rig.position)
            values = column[np.isfinite(column)]
            rows = np.arange(values.size, dtype=np.float64)
            signal = ScoredSignal(rig.position, rows, values, resolution(values))
            found.append(noise_level(signal, values).total)
        return float(np.median(found)) / rig.position_to_si

    def _input_noise(self, simulations: Simulations) -> dict[str, list[float]]:
        """[FMU's unit] Of each recorded input that enters at a port, for each recording."""
        file, variables = self.twin.file, self.twin.binding.variables
        found: dict[str, list[float]] = {}
        for port, variable in file.ports.items():
            for name, entry in file.inputs.items():
                if entry.variable != variable:
                    continue
                factor = variables[variable].variable.to_si
                found[port] = [
                    float(np.sqrt(fast_power(record.plan.experiment.inputs[name]))) / factor
                    for record in simulations.records
                    if name in record.plan.experiment.inputs
                ]
        return {p: levels for p, levels in found.items() if len(levels) == len(simulations.records)}

    def _moving_torque(self, simulations: Simulations, nominal: Sequence[Simulated]) -> float:
        inertia = self._inertia()
        recorded = self._recorded_torque(simulations)
        largest = max([recorded, *(float(np.abs(run.response.effort).max()) for run in nominal)])
        if inertia is None:
            return largest
        accelerations = []
        for record, run in zip(simulations.records, nominal, strict=True):
            if "velocity" in run.response.states:
                rate = np.gradient(run.response.states["velocity"], record.plan.grid)
                accelerations.append(float(np.quantile(np.abs(rate), 0.999)))
        return max([largest, *(inertia * a for a in accelerations)])

    def _recorded_torque(self, simulations: Simulations) -> float:
        """[FMU's unit] Range of recorded outputs in the torque port's unit; 0 without one."""
        file, variables = self.twin.file, self.twin.binding.variables
        port = variables[file.ports["torque"]].variable if "torque" in file.ports else None
        if port is None or not port.si_unit:
            return 0.0
        alike = {
            name
            for name, entry in file.outputs.items()
            if variables[entry.variable].variable.si_unit == port.si_unit
        }
        return max(
            (
                float(np.abs(s.values - s.values.mean()).max()) / port.to_si
                for record in simulations.records
                for s in record.signals
                if s.name in alike
            ),
            default=0.0,
        )

    def _position_unit(self) -> str:
        state = self.twin.file.states.get("position")
        return "" if state is None else self.twin.binding.variables[state].variable.si_unit

    def _uncertain(self) -> tuple[Uncertain, ...]:
        found = []
        binding = self.twin.binding
        for name, (low, high) in self.twin.file.uncertain.items():
            variable = binding.variables[name].variable
            nominal = float(self.twin.parameters.get(name, binding.nominal(name)))
            low = max(low, variable.minimum if variable.minimum is not None else low)
            high = min(high, variable.maximum if variable.maximum is not None else high)
            found.append(Uncertain(name, nominal, low, high))
        return tuple(found)

    def _first_fit(
        self,
        simulations: Simulations,
        windows: Sequence[Window],
        rig: Rig,
        noise: list[dict[str, NoiseLevel]],
        setting: Setting,
        nominal: list[Simulated],
    ) -> tuple[Misfit, Fitted]:
        """Refit the parameters by a budget without the loop's noise, which they shape."""
        empty: list[list[Direction]] = [[] for _ in simulations.records]
        own = [
            white_variances(r, levels) for r, levels in zip(simulations.records, noise, strict=True)
        ]
        spectra = covariances(windows, simulations.records, rig, own, empty)
        misfit = Misfit(simulations, whiteners(windows, spectra, empty))
        base = fit(misfit, Hypothesis(setting), {}, parallel=True, iterations=6)
        require_run(nominal, self.twin.name)
        assert base is not None, "the nominal twin was simulated a moment ago"
        return misfit, base

    def _budget(
        self,
        simulations: Simulations,
        windows: tuple[Window, ...],
        rig: Rig,
        base: Fitted,
        ratio: float,
    ) -> Budget:
        noise = noise_levels(simulations.records, base.simulated)
        point = base.hypothesis.point(base.x)
        through = self._noise_runs(simulations, point, base.simulated, rig, noise)
        own = [
            own_variances(record, levels, changes, run, rig.position)
            for record, levels, changes, run in zip(
                simulations.records, noise, through, base.simulated, strict=True
            )
        ]
        spectra = covariances(windows, simulations.records, rig, own, through)
        directions = nuisance_directions(simulations, point, base.simulated, rig, ratio)
        squares = noise_squares(windows, simulations.records, rig, spectra)
        return Budget(
            windows, tuple(spectra), tuple(directions), tuple(through), tuple(own), squares
        )

    def _noise_runs(
        self,
        simulations: Simulations,
        point: Point,
        about: list[Simulated],
        rig: Rig,
        noise: list[dict[str, NoiseLevel]],
    ) -> list[list[Direction]]:
        counts = [
            s.resolution for r in simulations.records for s in r.signals if s.name == rig.position
        ]
        return noise_runs(
            simulations,
            point,
            about,
            self._position_noise(simulations, rig, noise),
            rig.position,
            self._input_noise(simulations),
            self.rng,
            float(np.median(counts)) / rig.position_to_si if counts else 0.0,
        )


def _jumps(held: NDArray[np.float64], new: NDArray[np.float64]) -> bool:
    """Whether a signal changes at communication points, as commands do, and not in between."""
    whole, at_point = float(np.sum(np.diff(held) ** 2)), float(np.sum((new - held) ** 2))
    return at_point > _JUMP_SHARE * whole > 0.0


def _written_by_gmfbo(recordings: Sequence[Recording]) -> bool:
    return all(recording.written_by for recording in recordings)
