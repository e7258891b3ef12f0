"""A digital twin: FMUs and a twin file, run as an information source."""

from __future__ import annotations

import copy
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from gmfbo.errors import FmuFileError, InputError, SimulationError
from gmfbo.recordings.columns.column_mapping import ColumnMapping
from gmfbo.recordings.columns.signal import SignalSpec
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.binding.bind import bind
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.binding.content_hash import content_hash
from gmfbo.sources.binding.fixed_step import fixed_step_advice
from gmfbo.sources.fmu_file.job import Outcome
from gmfbo.sources.fmu_file.platforms import warn_without_master
from gmfbo.sources.twin.driven_ports import twin_file_at, with_driven_ports
from gmfbo.sources.twin.from_rest import run_from_rest
from gmfbo.sources.twin.kept_workers import KeptWorkers
from gmfbo.sources.twin.parameter_values import check_parameters, run_parameters, starts_as_recorded
from gmfbo.sources.twin.run_plan import Experiment
from gmfbo.sources.twin.signals import signal_specs
from gmfbo.sources.twin_file.column_file import column_mapping
from gmfbo.sources.twin_file.toml_lines import line_of
from gmfbo.sources.twin_file.twin_file import TwinFile
from gmfbo.sources.worker.runner import InProcess, Runner, once_only

if TYPE_CHECKING:
    from gmfbo.space import GainSpace


class FmuTwin:
    """One or several FMUs whose signals a twin file names in the recording's words.

    The FMU's code first runs at the first `run`, in a worker process of its own, since a crash,
    `exit()` or hang inside an FMU takes its process with it. Such a run gives a trajectory with
    status `crashed` or `timeout`, and the next run gets a fresh worker.

    Row k of a trajectory holds the FMU's outputs at communication point t_k, before the inputs of
    t_k act. For an output with `logged = "new"` it holds the output one communication step later,
    as such a logger stores it; the last row repeats the one before.

    The FMUs begin at the start time of their default experiment, or at 0 s, whatever the first
    recorded time is; `[recording] clock = "fmu"` hands the recorded time over. Trajectories keep
    the recording's clock.

    Without [initial], or if the recording lacks its signals, the first reference is held until the
    outputs are at rest, for at most 5 s. A twin that does not settle starts with its FMU's own
    start values.

    Parameters
    ----------
    path : str or Path
        Twin file (`.toml`).
    parameters : mapping of str to float or str, optional
        FMU parameters [FMU's unit] for all runs, over the twin file's and the recording's; texts,
        truth values and enumeration items as words.
    isolated : bool
        Run in a worker process; False is for FMUs that are trusted.
    time_limit_s : float, optional
        [s] Wall-clock time that one simulation may take in the worker; else the twin file's, or
        10 s and 20 times the simulated time.
    step : float, optional
        [s] Communication step instead of the twin file's.
    driven_ports : sequence of str
        Ports that a recording may drive, `torque` by its signal `torque_disturbance`.

    Raises
    ------
    TwinFileError
        The twin file contradicts itself or its FMU, or has no such port.
    FmuFileError
        An FMU cannot be read, or cannot run on this machine.
    InputError
        A parameter is unknown, or outside the FMU's bounds.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        parameters: Mapping[str, float | str] | None = None,
        isolated: bool = True,
        time_limit_s: float | None = None,
        step: float | None = None,
        driven_ports: Sequence[str] = (),
    ) -> None:
        path = self._path = Path(path)
        if step is not None and not (step > 0.0 and np.isfinite(step)):
            raise InputError(f"step: expected a positive communication step [s], got {step}")
        if time_limit_s is not None and not time_limit_s > 0.0:
            raise InputError(f"time_limit_s: expected more than 0 s, got {time_limit_s}")
        self.driven_ports: tuple[str, ...] = tuple(driven_ports)
        self.file: TwinFile = with_driven_ports(twin_file_at(path), driven_ports, path.name)
        self.name: str = self.file.name
        self.step: float = step or self.file.step
        self._binding = bind(self.file, path.resolve().parent, path.name)
        given = self._binding.given(parameters or {})
        self._parameters, self._texts = given.numbers, given.texts
        check_parameters(self._binding, self._parameters)
        self._isolated, self._time_limit_s = isolated, time_limit_s or self.file.time_limit
        self._runner: Runner | None = None
        self._lock = threading.Lock()
        self.kept: KeptWorkers | None = None
        if (once := once_only(self._binding)) and not isolated:
            raise FmuFileError(
                f"'{once[0]}' can be instantiated only once in the life of a process; expected "
                "isolated = True, which gives each run a process of its own"
            )
        warn_without_master(stacklevel=2)

    @property
    def path(self) -> Path:
        """The twin file."""
        return self._path

    @property
    def binding(self) -> Binding:
        """The twin file joined to its FMUs."""
        return self._binding

    @property
    def parameters(self) -> Mapping[str, float]:
        """FMU parameters [FMU's unit] given over the twin file's."""
        return MappingProxyType(self._parameters)

    @property
    def resample(self) -> float | None:
        """[s] Step of an even clock that recordings are put on; None leaves them as they are."""
        return self.file.recording.resample

    @property
    def texts(self) -> Mapping[str, str]:
        """Parameters of type String given over the twin file's."""
        return MappingProxyType(self._texts)

    def nominal(self, name: str) -> float:
        """Value [FMU's unit] of a parameter in the twin's runs, unless a run overrides it.

        Parameters
        ----------
        name : str
            FMU parameter.
        """
        given = self._parameters.get(name)
        return float(self._binding.nominal(name) if given is None else given)

    def place_of(self, table: str, key: str) -> str:
        """Where the twin file states an entry: its name, with the line where that can be told.

        Parameters
        ----------
        table : str
            Such as `uncertain`.
        key : str
            Of the entry.
        """
        try:
            line = line_of(self._path.read_text(encoding="utf-8"), table, key)
        except (OSError, ValueError):
            line = None  # it was moved or changed meanwhile
        return self._path.name if line is None else f"{self._path.name}, line {line}"

    @cached_property
    def content_hash(self) -> str:
        """Hash of the twin file's content, the FMUs' bytes, the parameters and the step."""
        return content_hash(self._binding, {**self._parameters, **self._texts}, self.step)

    @cached_property
    def gains(self) -> GainSpace:
        """Box of the gains that tuning may move; gains fixed by the file are left out."""
        from gmfbo.space import Gain, GainSpace

        return GainSpace(
            tuple(
                Gain(name, gain.low, gain.high, gain.scale, gain.integer)
                for name, gain in self.file.gains.items()
                if not gain.fixed
            )
        )

    def signal_specs(self) -> Mapping[str, SignalSpec]:
        """Signals of the twin file, by name."""
        return signal_specs(self._binding, self._parameters)

    def column_mapping(self) -> ColumnMapping:
        """Mapping of the logger's columns, from the twin file's `columns`."""
        return column_mapping(self.file.columns, self.file.dialect)

    def parameter_tunable(self) -> Mapping[str, bool]:
        """Each FMU parameter, and whether it may change during a run."""
        parameters = self._binding.parameters
        return {name: bound.variable.tunable for name, bound in parameters.items()}

    def parameter_units(self) -> Mapping[str, str]:
        """Unit of each FMU parameter, as its FMU spells it; empty where it has none."""
        parameters = self._binding.parameters
        return {name: bound.variable.unit for name, bound in parameters.items()}

    def run(
        self,
        gains: Mapping[str, float] | Sequence[float],
        reference: Recording,
        *,
        parameters: Mapping[str, float | str] | None = None,
    ) -> Trajectory:
        """Simulate the twin at some gains; a failed simulation is a result, not an exception.

        Parameters
        ----------
        gains : mapping of str to float, or sequence of float
            [FMU's unit] By name, or one for each of `self.gains` in order. Other gains keep the
            value of the recording, twin file or FMU.
        reference : Recording
            Signals of [inputs] in SI, schedules, and parameters in force. The communication
            grid begins at its first row and covers its last.
        parameters : mapping of str to float or str, optional
            [FMU's unit] Over the twin's, the recording's and [initial]; words as for the twin.

        Returns
        -------
        Trajectory
            All [outputs] and the inputs that were driven, in SI; `status` says how it ended.

        Raises
        ------
        InputError
            A name is unknown or a value outside the FMU's bounds.
        RecordingError
            The recording cannot drive this twin.
        FmuFileError
            The FMU's library cannot be loaded on this machine.
        """
        started = time.perf_counter()
        named = self._named(gains)
        given = self._binding.given(parameters or {})
        override, texts = {**self._parameters, **given.numbers}, {**self._texts, **given.texts}
        chosen = run_parameters(self._binding, reference, override, named, texts)
        experiment = Experiment.prepare(self._binding, reference, chosen, self.step)
        with self._lock:
            runner = self._runner = self._runner or self._start()
            if starts_as_recorded(self._binding, reference):
                lead, result = 0, runner.run(experiment.order(0))[0]
            else:
                lead, result = run_from_rest(runner, experiment)
        self._warn(result.outcome)
        if result.outcome.status == "failed":
            advice = fixed_step_advice(self._binding, self.step)
            told = replace(result.outcome, message=result.outcome.message + advice)
            result = result._replace(outcome=told)
        seconds = time.perf_counter() - started
        return experiment.trajectory(result, lead, seconds)

    def values_at_start(
        self, names: Sequence[str], *, parameters: Mapping[str, float] | None = None
    ) -> dict[str, float]:
        """Read variables of the FMU right after its initialisation, all inputs at their starts.

        Parameters
        ----------
        names : sequence of str
            Outputs, local variables or parameters that are numbers.
        parameters : mapping of str to float, optional
            [FMU's unit] Over the twin's.

        Returns
        -------
        dict of str to float
            [FMU's unit]

        Raises
        ------
        InputError
            A name is unknown or a value outside the FMU's bounds.
        SimulationError
            The FMU did not initialise.
        """
        from gmfbo.sources.twin.values_at_start import initial_order

        override = {**self._parameters, **(parameters or {})}
        order = initial_order(self._binding, names, override, self._texts)
        with self._lock:
            runner = self._runner = self._runner or self._start()
            outcome, read = runner.run(order)[0]
        if outcome.rows == 0:
            raise SimulationError(f"{self.name}: {outcome.message}; run 'gmfbo simulate' on it")
        return dict(zip(names, map(float, read[0]), strict=True))

    def close(self) -> None:
        """End the worker and remove its files; a later run starts anew."""
        with self._lock:
            if self._runner is not None:
                self._runner.close()
                self._runner = None

    @contextmanager
    def keeping_workers(self) -> Iterator[None]:
        """Within it, what runs this twin with physics takes over workers that another gave back.

        To start one takes 0.2 s.
        """
        if self.kept is not None:
            yield  # they are kept for longer
            return
        self.kept = kept = KeptWorkers()
        try:
            yield
        finally:
            self.kept = None
            kept.close()

    def with_uncertain(self, uncertain: Mapping[str, tuple[float, float]]) -> FmuTwin:
        """The same twin, of which other parameters are uncertain.

        Parameters
        ----------
        uncertain : mapping of str to (float, float)
            [FMU's unit] Range of each, in place of the twin file's.
        """
        other = copy.copy(self)
        other.file = self.file.model_copy(update={"uncertain": dict(uncertain)})
        other.kept, other._binding = self.kept, self._binding
        return other

    def with_file(self, file: TwinFile) -> FmuTwin:
        """The same FMUs under another twin file.

        Parameters
        ----------
        file : TwinFile
            Of the same variables.
        """
        other = self.with_uncertain(file.uncertain)
        other.file, other._binding = file, replace(self._binding, file=file)
        return other

    def __reduce__(self) -> tuple[Callable[[], FmuTwin], tuple[()]]:
        """Pickle the arguments only: a copy in another process opens a worker of its own."""
        opened = partial(
            _opened_again,
            self.file,
            self._path.resolve(),
            parameters={**self._parameters, **self._texts},
            isolated=self._isolated,
            time_limit_s=self._time_limit_s,
            step=self.step,
            driven_ports=self.driven_ports,
        )
        return opened, ()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<FmuTwin '{self.name}': {', '.join(fmu.path.name for fmu in self._binding.fmus)}>"

    def _named(self, gains: Mapping[str, float] | Sequence[float]) -> dict[str, float]:
        if isinstance(gains, Mapping):
            return dict(gains)
        return self.gains.named(self.gains.point(gains))

    def _start(self) -> Runner:
        if not self._isolated:
            return InProcess(self._binding)
        from gmfbo.sources.worker.isolation import Isolated

        return Isolated(self._binding, time_limit_s=self._time_limit_s)

    def _warn(self, outcome: Outcome) -> None:
        if outcome.warnings:
            warnings.warn(
                f"{self.name}: the FMU answered {outcome.warnings} calls with a warning",
                RuntimeWarning,
                stacklevel=3,
            )


def _opened_again(file: TwinFile, path: Path, **given: Any) -> FmuTwin:
    """A twin in another process, under the twin file that it had and not the one on the disk."""
    twin = FmuTwin(path, **given)
    return twin if twin.file == file else twin.with_file(file)
