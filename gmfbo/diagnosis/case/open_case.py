"""From a twin and recordings to a case: measured, aligned and refitted."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.fitted_starts import (
    begun_at_first_rows,
    fitted_with_starts,
    settle_starts,
)
from gmfbo.diagnosis.case.measured_budget import measured_budget, without_loop_noise
from gmfbo.diagnosis.case.opening_notes import not_scored
from gmfbo.diagnosis.case.other_starts import fitted_from_elsewhere
from gmfbo.diagnosis.case.probed_loop import begun_at_rest, probed_loop
from gmfbo.diagnosis.case.recorded_reading import recorded_reading
from gmfbo.diagnosis.case.tracking import track_recordings
from gmfbo.diagnosis.case.wider_ranges import WiderRanges, stated_ranges
from gmfbo.diagnosis.fitting.difference_steps import with_clear_steps
from gmfbo.diagnosis.fitting.fit import Fitted, fit, fit_to_the_end
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis, Setting
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.noise.measured_noise import noise_of_all, position_noise
from gmfbo.diagnosis.noise.open_loop_noise import leave_out_noise
from gmfbo.diagnosis.runs.logging_convention import logged_new
from gmfbo.diagnosis.runs.measured_excitation import Stiffness, measure_ranges, recorded_speed
from gmfbo.diagnosis.runs.probing_torque import command_range, moving_torque
from gmfbo.diagnosis.runs.scored_record import Record, scored_record
from gmfbo.diagnosis.runs.simulated import Point, Reading, Simulated, require_run
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.runs.twin_steps import reads_back, steps_finely
from gmfbo.diagnosis.scoring.long_rests import mark_long_rests
from gmfbo.diagnosis.scoring.noise_levels import NoiseLevel, noise_levels
from gmfbo.diagnosis.scoring.signal_parts import Rig, describe_rig, speed_scales
from gmfbo.diagnosis.scoring.whitening import Window
from gmfbo.diagnosis.scoring.windows import windows_of
from gmfbo.errors import RecordingError
from gmfbo.physics import Excitation
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.uncertain import Uncertain

FINEST_STEP_S = 2e-4
"""[s] Step of twin and physics: at it, effects on commands lose less than 1 % to the hold."""

_MOST_SUBSTEPS = 10
_USUAL_LOOP_TIME_S = 0.05


def open_case(
    twin: FmuTwin,
    recordings: Sequence[Recording],
    *,
    seed: int,
    jobs: int | None,
    new_rows: frozenset[str] | None = None,
    on_run: Callable[[], None] = lambda: None,
    wider: WiderRanges | None = None,
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
    wider : WiderRanges, optional
        Ranges in place of those in the twin file, and where the fit starts.

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
    opening.wider = wider or WiderRanges({}, {})
    case = opening.case(substeps)
    case.notes += not_scored(case)
    return case


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


def _compared(simulations: Simulations) -> set[str]:
    return {signal.name for record in simulations.records for signal in record.signals}


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
        self.wider = WiderRanges({}, {})
        self.sensor_included = self.refines = False

    def case(self, substeps: int) -> Case:
        finely = substeps == 1 or steps_finely(self.twin, self.recordings[0], substeps)
        self.refines = finely and (substeps > 1 or steps_finely(self.twin, self.recordings[0], 2))
        if not finely:
            substeps = 1
            self.notes.append(
                "the twin gives other results, or none, at a finer communication step: physics was "
                f"stepped at {self.twin.step:g} s, at which effects on the command are less exact"
            )
        self.sensor_included = reads_back(self.twin, self.recordings[0], substeps)
        simulations = self._simulations(substeps)
        try:
            return self._case(simulations, substeps)
        except BaseException:
            simulations.close()
            raise

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
        simulations.rest = like.simulations.rest
        nominal = simulations.run([Point()])[0]
        require_run(nominal, f"{self.twin.name}: the twin as it is cannot follow the recordings")
        nominal = begun_at_first_rows(simulations, self.twin, nominal)
        excitation = like.setting.excitation
        if simulations.tracking is None:
            nominal, _ = begun_at_rest(simulations, nominal, like.rig, excitation.loop_time)
        noise = noise_levels(simulations.records, nominal)
        mark_long_rests(simulations, nominal, like.rig.position, excitation.loop_time)
        windows = windows_of(simulations.records, excitation.loop_time)
        misfit = without_loop_noise(simulations, windows, like.rig, noise)
        hypothesis = Hypothesis(like.setting)
        base = fit(misfit, hypothesis, like.base.parameters, parallel=True, iterations=1)
        assert base is not None, "the nominal twin was simulated a moment ago"
        if settle_starts(misfit, base):
            base = fit(misfit, hypothesis, base.parameters, parallel=True, iterations=1)
            assert base is not None, "it was simulated at these values a moment ago"
        if leave_out_noise(simulations, like.rig, base) is not None:
            nominal = simulations.run([Point()])[0]
            base = fit(misfit, hypothesis, base.parameters, parallel=True, iterations=1)
            assert base is not None, "it was simulated at these values a moment ago"
        ratio = excitation.torque / excitation.command
        budget = measured_budget(self.twin, simulations, windows, like.rig, base, ratio, self.rng)
        misfit = Misfit(simulations, budget.whiteners())
        return Case(
            self.twin,
            simulations,
            like.substeps,
            like.rig,
            nominal,
            noise_of_all(simulations, like.rig, noise),
            budget,
            misfit,
            like.setting,
            base.measured_by(misfit),
            self.notes,
        )

    def _simulations(self, substeps: int) -> Simulations:
        included = self.sensor_included
        open_twin = partial(AugmentedTwin, self.twin, substeps=substeps, sensor_included=included)
        with open_twin() as first:
            records = self._records(first)
        simulations = Simulations(open_twin, records, self.jobs)
        simulations.on_run = self.on_run
        if self.refines:
            simulations.finer = lambda: self._simulations(2 * substeps)
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
        nominal = begun_at_first_rows(simulations, self.twin, nominal)
        rig = describe_rig(self.twin.binding, _compared(simulations))
        simulations.reading = recorded_reading(self.twin, simulations, rig, substeps)
        if rig.position is not None:
            simulations.encoder = Reading(rig.position, rig.position_to_si)
        stiffness, nominal, notes = probed_loop(simulations, nominal, rig, self._inertia())
        self.notes += notes
        if stiffness is not None and stiffness.is_open and rig.position is not None:
            self._track(simulations, rig, stiffness.inertia)
            nominal = simulations.run([Point()])[0]
            require_run(nominal, f"{self.twin.name}: the twin cannot be held on its recordings")
        simulations.new_rows = (
            logged_new(self.twin, self.recordings, simulations, nominal)
            if self.new_rows is None
            else self.new_rows
        )
        nominal = self._reread(simulations, nominal)
        noise = noise_levels(simulations.records, nominal)
        ratio = 1.0 if stiffness is None else stiffness.per_command
        if not np.isfinite(ratio):
            ratio = 1.0  # torque and command taken to be in one unit
        loop_time = self._loop_time(stiffness)
        excitation = self._excitation(simulations, nominal, rig, noise, ratio, loop_time, substeps)
        setting = self._setting(excitation)
        self.notes += mark_long_rests(simulations, nominal, rig.position, loop_time)
        windows = windows_of(simulations.records, loop_time, nominal, rig.positions)
        base = self._first_fit(simulations, windows, rig, noise, setting)
        answered = leave_out_noise(simulations, rig, base)
        if answered:
            self.notes.append(
                f"{answered:.0%} of the fast part of the recorded command answers noise of the "
                "recorded position: it was not played into the twin"
            )
        if answered is not None:
            nominal = simulations.run([Point()])[0]
            base = self._first_fit(simulations, windows, rig, noise, setting)
        setting = base.hypothesis.setting
        budget = measured_budget(self.twin, simulations, windows, rig, base, ratio, self.rng)
        misfit = Misfit(simulations, budget.whiteners())
        refitted = fit_to_the_end(misfit, Hypothesis(setting), base.parameters)
        assert refitted is not None, "it was simulated at these values a moment ago"
        levels = noise_levels(simulations.records, base.simulated)
        if simulations.starts:  # where the fit has found that the recordings start
            nominal = simulations.run([Point()])[0]
        return Case(
            self.twin,
            simulations,
            substeps,
            rig,
            nominal,
            noise_of_all(simulations, rig, levels),
            budget,
            misfit,
            setting,
            refitted,
            self.notes,
        )

    # ---- steps -----------------------------------------------------------------------------

    def _inertia(self) -> float | None:
        role = self.twin.file.roles.get("inertia")
        if role is None:
            return None
        return self.twin.nominal(role)

    def _track(self, simulations: Simulations, rig: Rig, inertia: float | None) -> None:
        track_recordings(simulations, rig, self._inertia() or inertia or 1.0)
        self.notes.append(
            "the twin is an open-loop plant: a slow tracking loop kept it near each recording, "
            "and what that leaves was scored"
        )

    def _loop_time(self, stiffness: Stiffness | None) -> float:
        """[s] Time constant of the closed loop, or a usual one where no push has shown it."""
        if stiffness is None or not np.isfinite(stiffness.loop_time):
            return _USUAL_LOOP_TIME_S
        return max(stiffness.loop_time, 2.0 * self.twin.step)

    def _reread(self, simulations: Simulations, simulated: Sequence[Simulated]) -> list[Simulated]:
        read = simulations.read
        return [replace(r, signals=read(r.response, k)) for k, r in enumerate(simulated)]

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
        command = command_range(self.twin, simulations, nominal)
        torque = ratio * command
        if simulations.tracking is not None or torque <= 0.0:
            torque = moving_torque(self.twin, simulations, nominal, self._inertia())
        resolution = position_noise(simulations, rig, noise) or 0.0
        return measure_ranges(
            simulations.records,
            nominal,
            torque=torque,
            command=command,
            speed=recorded_speed(
                simulations.records, speed_scales(self.twin.binding, rig), rig.position
            ),
            step=self.twin.step / substeps,
            loop_time=loop_time,
            resolution=resolution,
            inertia=self._inertia(),
            angular="m" not in {self._position_unit(), ""},
        )

    def _position_unit(self) -> str:
        state = self.twin.file.states.get("position")
        return "" if state is None else self.twin.binding.variables[state].variable.si_unit

    def _setting(self, excitation: Excitation) -> Setting:
        role = self.twin.file.roles.get("inertia")
        least = self.twin.binding.variables[role].variable.minimum if role else None
        return Setting(self._uncertain(), excitation, role, least or 0.0)

    def _uncertain(self) -> tuple[Uncertain, ...]:
        ranges = {**stated_ranges(self.twin), **self.wider.ranges}
        return tuple(
            Uncertain(name, self.twin.nominal(name), low, high)
            for name, (low, high) in ranges.items()
        )

    def _first_fit(
        self,
        simulations: Simulations,
        windows: Sequence[Window],
        rig: Rig,
        noise: list[dict[str, NoiseLevel]],
        setting: Setting,
    ) -> Fitted:
        """Refit the parameters by a budget without the loop's noise, which they shape."""
        misfit = without_loop_noise(simulations, windows, rig, noise)
        start = self.wider.values
        hypothesis = with_clear_steps(misfit, Hypothesis(setting), start, parallel=True)
        if simulations.starts:
            return fitted_with_starts(misfit, hypothesis, start)
        base = fit_to_the_end(misfit, hypothesis, start)
        assert base is not None, "the nominal twin was simulated a moment ago"
        return fitted_from_elsewhere(misfit, base)
