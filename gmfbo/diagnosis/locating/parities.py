"""Check controller, plant and transmission separately against the recordings.

The recorded measurement is fed to the twin's controller, whose command must equal the recorded
one. At the same time a virtual spring and damper hold the plant on the recording; their torque is
the torque that the plant lacks (parity relations, Gertler 1998).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.locating.controller_memory import (
    ControllerMemory,
    beside_memory,
    controller_memories,
)
from gmfbo.diagnosis.locating.held_twin import DISTURBANCE, HeldTwin, hold, mean_effort
from gmfbo.diagnosis.locating.parity import (
    Parity,
    block_rows,
    block_spread,
    fast_noise,
    without_nuisances,
)
from gmfbo.diagnosis.locating.slower_rows import (
    are_slower,
    as_logged,
    computing_interval,
    hidden_by_rows,
    row_interval,
    why_slower,
)
from gmfbo.diagnosis.locating.unchecked_controller import (
    OPEN_LOOP,
    why_no_command,
    why_no_position,
    why_no_sensor,
)
from gmfbo.diagnosis.locating.unrecorded_inputs import read_by_controller, why_not_judged
from gmfbo.diagnosis.runs.scored_record import ScoredSignal
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.scoring.noise_levels import TOLERANCE
from gmfbo.diagnosis.scoring.nuisances import ACTUATOR_GAIN, ACTUATOR_LAG_S, SHIFT_SHARE
from gmfbo.sources.twin.response import Response

CLEARLY = 2.0
"""Times the residual's square of one logger, where the controller is wrong or not known whole."""

_PASSES_BELOW = 1.0  # mean square of scores of a null simulation
_LOAD_SHARE = 1.0 / 3.0  # of the torque's range: its typical size where it is not recorded

Column = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Parities:
    """Residuals of the parts of the loop that could be checked.

    Attributes
    ----------
    controller : Parity or None
        [SI unit of the command] Recorded minus computed on the recorded measurement.
    plant : Parity or None
        [unit of the torque port] Torque that holds the twin on the recording.
    transmission : Parity or None
        [SI unit of the position] Recorded minus simulated load position, given the motor's.
    why_not : mapping of str to str
        `controller`, `plant`, `transmission`: why it could not be checked.
    logged : mapping of str to float
        Mean square of the command's residual if the logger stores the `held` or the `new` command;
        empty where the controller could not be checked.
    held : tuple of Simulated
        The twin while it was held on each recording; empty where it could not be held.
    slower_rows : bool
        Whether rows are slower than the controller: its parity then shows gross errors alone.
    memories : tuple of ControllerMemory
        By recording, what the controller may have held before it; empty where it is not checked.
    """

    controller: Parity | None
    plant: Parity | None
    transmission: Parity | None
    why_not: Mapping[str, str]
    logged: Mapping[str, float] = field(default_factory=dict)
    held: tuple[Simulated, ...] = ()
    slower_rows: bool = False
    memories: tuple[ControllerMemory, ...] = ()


def logged_as(checked: Parities) -> str | None:
    """Whether the logger stores the `held` or the `new` command; None where it is unclear."""
    if not checked.logged:
        return None
    held, new = checked.logged["held"], checked.logged["new"]
    return None if held == new else ("new" if new < held else "held")


def parities(case: Case, base: Fitted) -> Parities:
    """Check each part of the loop on its own, by the residuals of the model `base`."""
    return _Checks(case, base).run()


class _Checks:
    """Residuals of all parts, or the reason why a part has none."""

    def __init__(self, case: Case, base: Fitted) -> None:
        self.case, self.base = case, base
        self.records = case.simulations.records
        self.grids = [record.plan.grid for record in self.records]
        self.rows = float(np.mean([block_rows(grid) for grid in self.grids]))
        self.command = self._command()
        self.why_not: dict[str, str] = {}
        self.slower_rows = False
        self.memories: tuple[ControllerMemory, ...] = ()

    def run(self) -> Parities:
        transmission = self._transmission()
        if self.case.simulations.tracking is not None:
            self.why_not["controller"] = OPEN_LOOP
            kept = tuple(self.base.simulated)
            return Parities(None, self._open_loop(), transmission, self.why_not, held=kept)
        twin = self._held_twin()
        if twin is None or not twin.settings:
            return Parities(None, None, transmission, self.why_not)
        measured = [twin.recorded(k) for k in range(len(self.records))]
        held = twin.run(dict(enumerate(measured)))
        if held is None:
            for name in ("controller", "plant"):
                self.why_not.setdefault(name, "the twin cannot be held on its recordings")
            return Parities(None, None, transmission, self.why_not)
        efforts = []
        if twin.holds_plant:
            efforts = [twin.effort(m, run) for m, run in zip(measured, held, strict=True)]
        controller, logged = self._judged(twin, held, efforts)
        plant = None
        if twin.holds_plant:
            if controller is not None and controller.fails:
                efforts = self._under_recorded_command(efforts, controller)
            plant = self._plant(efforts, held, self._noise_of_effort(twin))
        kept = tuple(Simulated((), run) for run in held)
        return Parities(
            controller,
            plant,
            transmission,
            self.why_not,
            logged,
            kept,
            self.slower_rows,
            self.memories,
        )

    def _held_twin(self) -> HeldTwin | None:
        position = self.case.rig.position
        if position is None or not all(
            position in record.plan.recording.signals for record in self.records
        ):
            self.why_not["plant"] = "the position was not recorded"
            self.why_not["controller"] = why_no_position(self.case.twin.file)
            return None
        twin = hold(self.case, self.base, position)
        if not twin.holds_plant:
            self.why_not["plant"] = "the twin has no torque port"
        if not twin.feeds_controller:
            self.why_not["controller"] = why_no_sensor(self.case.twin.file)
        elif self.command is None:
            self.why_not["controller"] = why_no_command(self.case.twin.file)
        return twin

    def _command(self) -> str | None:
        """Output with the role `command`, where it is scored in every recording."""
        file = self.case.twin.file
        wanted = file.states.get("command")
        for name, entry in file.outputs.items():
            scored = all(any(s.name == name for s in r.signals) for r in self.records)
            if wanted is not None and entry.variable == wanted and scored:
                return name
        return None

    def _judged(
        self, twin: HeldTwin, held: Sequence[Response], efforts: Sequence[Column]
    ) -> tuple[Parity | None, dict[str, float]]:
        """Controller's parity where it can be judged, and what that tells of the logger."""
        if self.command is None or not twin.feeds_controller:
            return None, {}
        rows = row_interval(self.case, twin.position)
        interval = computing_interval(self.base, self.command, self.case.twin.step)
        self.slower_rows = are_slower(rows, interval)
        hidden = hidden_by_rows(twin, self.command, held, rows) if self.slower_rows else 0.0
        leak = self._leak(twin, self.command, hidden)
        if leak is None:
            return None, {}
        size = float(np.hypot(leak * self._more(efforts), hidden))
        self.memories = controller_memories(twin, self.command, held, max(rows, interval))
        controller, logged = self._controller(held, self.command, size)
        if self.slower_rows:
            logged = {}
        # A command that comes out as recorded needs no input that nobody knows.
        if controller.fails and not self._reads_only_what_is_known(twin, self.command):
            # What the logger stores may show all the same.
            is_clear = logged and max(logged.values()) >= CLEARLY * min(logged.values())
            return None, logged if is_clear else {}
        if self.slower_rows and not controller.fails:
            self.why_not["controller"] = why_slower(rows, interval)
            return None, {}
        return controller, logged

    def _leak(self, twin: HeldTwin, command: str, hidden: float) -> float | None:
        """Spread of the command's error in a null simulation; None where the test fails.

        `hidden` is what rows slower than the controller make of it besides.

        The twin computes the command under a disturbance, and again without it, held on its own
        measurement. Without a disturbance, a sensor port that feeds nothing would pass.
        """
        k = twin.busiest
        run = twin.disturbed(k)
        back = twin.run({k: twin.logged(k, run.response.held[twin.position])})
        if not run.finite or back is None:
            self.why_not["controller"] = "a null simulation of it did not run to its end"
            return None
        residual = run.response.held[command] - back[0].held[command]
        spread = block_spread([self.grids[k]], [self._scored(k, residual)])
        noise = self._command_noise(command, self.case.noise[command].total)
        noise = float(np.hypot(noise, hidden))
        if (spread / noise) ** 2 > _PASSES_BELOW:
            self.why_not["controller"] = (
                "the twin's own command does not come out when its own measurement is fed back "
                "through the sensor port: the port does not feed every path of the controller, "
                "or the twin adds noise of its own"
            )
            return None
        return spread

    def _reads_only_what_is_known(self, twin: HeldTwin, command: str) -> bool:
        """Whether every input that moves the command was recorded or is stated."""
        unknown = read_by_controller(self.case, twin, command)
        if unknown:
            self.why_not["controller"] = why_not_judged(self.case, unknown)
        return not unknown

    def _more(self, efforts: Sequence[Column]) -> float:
        """Ratio of the recordings' disturbance to that of the null simulation, at least 1."""
        if not efforts:
            return 1.0
        hidden = DISTURBANCE * self.case.setting.excitation.torque
        scored = [self._scored(k, effort) for k, effort in enumerate(efforts)]
        return max(1.0, block_spread(self.grids, scored) / hidden)

    def _noise_of_effort(self, twin: HeldTwin) -> float:
        """Spread of the effort's block means caused by noise of the recorded position."""
        k = twin.busiest
        clean = self.base.simulated[k].response.held[twin.position]
        level = self.case.noise[twin.position].total if twin.position in self.case.noise else 0.0
        noisy = twin.logged(k, clean + level * np.random.default_rng(0).standard_normal(clean.size))
        runs = twin.run({k: noisy})
        if runs is None:
            return 0.0
        return block_spread([self.grids[k]], [self._scored(k, twin.effort(noisy, runs[0]))])

    def _controller(
        self, held: Sequence[Response], name: str, leak: float
    ) -> tuple[Parity, dict[str, float]]:
        both = {
            which: [
                self._command_residual(k, name, which, getattr(r, which)[name])
                for k, r in enumerate(held)
            ]
            for which in ("held", "new")
        }
        logged = {
            key: float(np.nanmean(np.concatenate([np.diff(c) for c in columns]) ** 2))
            for key, columns in both.items()
        }
        columns = both["new" if name in self.case.simulations.new_rows else "held"]
        fast = float(np.median([self._fast(name, k, both) for k in range(len(columns))]))
        noise = self._command_noise(name, max(fast, self.case.noise[name].least))
        noise = float(np.hypot(noise, leak))
        return Parity(tuple(columns), tuple(self.grids), noise, self._unit(name)), logged

    def _fast(self, name: str, k: int, both: Mapping[str, Sequence[Column]]) -> float:
        """Noise of a recording's residual, by whichever convention its rows follow."""
        # Between two rows the column is a straight line: it has noise of its own at rows alone.
        time = self._signal(k, name).time
        return min(fast_noise(np.interp(time, self.grids[k], own[k])) for own in both.values())

    def _command_residual(self, k: int, name: str, which: str, computed: Column) -> Column:
        """Recorded minus computed command, without the part that nuisances explain."""
        signal = self._signal(k, name)
        grid, prior = self.grids[k], self.case.rig.alignments[name]
        if not self.slower_rows:
            computed = as_logged(computed, grid, signal.time)
        shift = prior.shift or SHIFT_SHARE * signal.spacing
        columns = [prior.scale * computed, shift * np.gradient(computed, grid)]
        if prior.offset:
            columns.append(np.full(grid.size, prior.offset * float(np.ptp(signal.values))))
        memory = self.memories[k]
        told = [
            beside_memory(
                np.where(memory.tells(grid), self._scored(k, column), np.nan), memory.answers[which]
            )
            for column in (self._on_grid(k, name) - computed, *columns)
        ]
        return without_nuisances(told[0], told[1:], self.case.noise[name].total)

    def _command_noise(self, name: str, level: float) -> float:
        """Spread of the command's block means: white noise of this level, and a tolerance."""
        rms = [np.sqrt(np.mean(run.response.held[name] ** 2)) for run in self.base.simulated]
        counts = [block_rows(self._signal(k, name).time) for k in range(len(self.records))]
        white = level / np.sqrt(np.mean(counts))
        return max(float(np.hypot(white, TOLERANCE * np.median(rms))), 1e-15)

    def _under_recorded_command(
        self, efforts: Sequence[Column], controller: Parity
    ) -> list[Column]:
        """Effort corrected to the recorded command, where the twin's command differs."""
        ratio = self.case.setting.excitation.torque / self.case.setting.excitation.command
        return [e - ratio * c for e, c in zip(efforts, controller.columns, strict=True)]

    def _plant(self, efforts: Sequence[Column], held: Sequence[Response], noise: float) -> Parity:
        """Effort without the part that the actuator's nuisances explain."""
        excitation = self.case.setting.excitation
        ratio = excitation.torque / excitation.command
        columns, rms = [], []
        for k, (effort, run) in enumerate(zip(efforts, held, strict=True)):
            residual = self._scored(k, effort)
            if self.case.simulations.tracking is None and "command" in run.states:
                driving = ratio * run.states["command"]
                rate = np.gradient(driving, self.grids[k])
                small = [ACTUATOR_GAIN * driving, ACTUATOR_LAG_S * rate]
                rms.append(float(np.sqrt(np.mean(driving**2))))
                spread = float(np.hypot(noise, TOLERANCE * rms[-1]))
                # By means of blocks: command and effort share the noise of the measurement.
                residual = without_nuisances(residual, small, spread, block_rows(self.grids[k]))
            columns.append(residual)
        typical = float(np.median(rms)) if rms else _LOAD_SHARE * excitation.torque
        total = max(float(np.hypot(noise, TOLERANCE * typical)), 1e-15)
        unit = self._variable_unit(self.case.twin.file.ports["torque"])
        return Parity(tuple(columns), tuple(self.grids), total, unit)

    def _open_loop(self) -> Parity:
        """Parity of an open-loop plant: the effort of the loop that holds it on its recordings."""
        tracking = self.case.simulations.tracking
        assert tracking is not None, "asked of a twin that is held"
        held = [run.response for run in self.base.simulated]
        efforts = [
            mean_effort(tracking.settings, measured, run, self.case.twin.step)
            for measured, run in zip(tracking.measured, held, strict=True)
        ]
        noise = float(np.median([fast_noise(self._scored(k, e)) for k, e in enumerate(efforts)]))
        return self._plant(efforts, held, noise / np.sqrt(self.rows))

    def _transmission(self) -> Parity | None:
        file, motor = self.case.twin.file, self.case.rig.position
        wanted = file.states.get("load_position")
        load = next((n for n, e in file.outputs.items() if wanted and e.variable == wanted), None)
        if (
            load is None
            or motor is None
            or load == motor
            or not all({motor, load} <= {s.name for s in r.signals} for r in self.records)
        ):
            self.why_not["transmission"] = "the load's position was not recorded beside the motor's"
            return None
        columns = []
        for k, run in enumerate(self.base.simulated):
            simulated = run.response.held
            ratio = float(np.polyfit(simulated[motor], simulated[load], 1)[0])
            change = {name: self._on_grid(k, name) - simulated[name] for name in (motor, load)}
            column = self._scored(k, change[load] - ratio * change[motor])
            columns.append(column - np.nanmean(column))
        level = float(np.hypot(self.case.noise[load].total, self.case.noise[motor].total))
        noise = level / np.sqrt(self.rows)
        return Parity(tuple(columns), tuple(self.grids), noise, self._unit(load))

    def _signal(self, k: int, name: str) -> ScoredSignal:
        return next(s for s in self.records[k].signals if s.name == name)

    def _on_grid(self, k: int, name: str) -> Column:
        signal = self._signal(k, name)
        return np.asarray(np.interp(self.grids[k], signal.time, signal.values), dtype=np.float64)

    def _scored(self, k: int, column: Column) -> Column:
        record, grid = self.records[k], self.grids[k]
        inside = (grid >= record.start - 1e-9) & (grid <= record.end + 1e-9)
        return np.where(inside, column, np.nan)

    def _unit(self, signal: str) -> str:
        return self._variable_unit(self.case.twin.file.outputs[signal].variable)

    def _variable_unit(self, variable: str) -> str:
        return self.case.twin.binding.variables[variable].variable.si_unit
