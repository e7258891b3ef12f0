"""Information sources of a study, opened as its file names them."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gmfbo.errors import InputError, NotTheGainsError, SimulationError, StudyFileError
from gmfbo.files.user_function import load_function
from gmfbo.objective.limits import Limits
from gmfbo.recordings.columns.signal import SignalReading
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.plants.plant_call import PlantFunction, PythonPlant
from gmfbo.sources.plants.plant_command import CommandPlant
from gmfbo.sources.plants.recorded_grid import RecordedGrid
from gmfbo.sources.plants.source import Source
from gmfbo.space import GainSpace
from gmfbo.tuning.experiment.loop_margins import COMMAND_PORT, FINER
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.study_file.study_sections import PlantSection, StudyFile

if TYPE_CHECKING:
    from gmfbo.sources.twin.twin import FmuTwin


@dataclass(frozen=True, eq=False)
class StudySources:
    """The sources of one study.

    Attributes
    ----------
    is1 : Source or None
        Real axis, or the FMU that plays it; None where somebody else runs it (ask and tell).
    is2 : Source
        Digital twin.
    opened : ExitStack
        Closes the sources that were opened for the study; those handed in stay with their owner.
    changed_is1 : Source or None
        The plant after its change.
    change_after : int or None
        Real runs before the change.
    gains : GainSpace or None
        Box of the twin file; None where the twin is the user's own source.
    parameters : tuple of str
        All FMU parameters of the twin; empty where it is the user's own source.
    units : mapping of str to str
        Unit of each of them, as the FMU spells it.
    reference_unit : str
        SI unit of the reference; empty where unknown.
    reading : SignalReading or None
        Twin file of IS2, which gives the meaning of a recording's columns; None where the twin
        is the user's own source.
    command, velocity : str or None
        Outputs of the twin that are the states `command` and `velocity` of its file.
    loop_twins : tuple of FmuTwin
        The twin with its command port driven, stepped finely and at its own step; empty unless a
        margin is limited.
    """

    is1: Source | None
    is2: Source
    opened: ExitStack
    changed_is1: Source | None = None
    change_after: int | None = None
    gains: GainSpace | None = None
    parameters: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    reference_unit: str = ""
    reading: SignalReading | None = None
    command: str | None = None
    velocity: str | None = None
    loop_twins: tuple[FmuTwin, ...] = ()

    @classmethod
    def open(
        cls,
        study: StudyFile,
        folder: Path,
        *,
        is1: Source | None = None,
        is2: Source | None = None,
        plant: PlantFunction | None = None,
    ) -> StudySources:
        """Open the twins that a study names.

        Parameters
        ----------
        study : StudyFile
            The validated file.
        folder : Path
            Folder to which its paths are relative.
        is1, is2 : Source, optional
            Used instead of the file's: a test bench, or a simulator of the user's own.
        plant : callable, optional
            Called with gains and reference instead of the IS1 that the file names.

        Raises
        ------
        StudyFileError
            The plant changes, but is not an FMU.
        TwinFileError, FmuFileError
            A twin cannot be opened.
        """
        _check_plant(study, is1, plant)
        change = study.is1.change
        changed = None
        facts: dict[str, Any] = {}
        reading: SignalReading | None = is2 if isinstance(is2, SignalReading) else None
        with ExitStack() as opened:
            opener = _Opener(study.seed, folder, opened, disturbed_ports(study))
            if is2 is None:
                is2 = reading = twin = opener.twin(study.is2.twin, study.is2.parameters)
                facts = _facts_of(twin, study)
                if Limits(study.constraints).of_the_twin:
                    facts["loop_twins"] = opener.loop_twins(twin)
            if plant is not None:
                is1 = PythonPlant(plant, reading)
            if is1 is None:
                is1 = opener.plant(study.is1, reading)
                if study.is1.twin is not None and change is not None:
                    after = {**opener.plant_parameters(study.is1), **change.parameters}
                    changed = opener.twin(study.is1.twin, after)
            return cls(
                is1=is1,
                is2=is2,
                opened=opened.pop_all(),
                changed_is1=changed,
                change_after=change.after_runs if change else None,
                reading=reading,
                **facts,
            )

    def units_of(self, gains: GainChoice) -> dict[str, str]:
        """Unit of each gain, as the twin's FMU spells it; empty where it has none.

        Parameters
        ----------
        gains : GainChoice
            Tuned and fixed ones.
        """
        return {name: self.units.get(name, "") for name in (*gains.space.names, *gains.fixed)}

    def told_of(self, gains: GainChoice) -> dict[str, Any]:
        """What a reader of the log has to know of the gains.

        Parameters
        ----------
        gains : GainChoice
            Tuned and fixed ones.

        Returns
        -------
        dict
            `units` by gain, as the twin's FMU spells them, empty where it has none; `box` with the
            range of each tuned gain, which may be the twin file's.
        """
        box = [asdict(gain) for gain in gains.space.gains]
        return {"units": self.units_of(gains), "box": box}

    def real(self, runs_before: int) -> Source | None:
        """Source of the next real run.

        Parameters
        ----------
        runs_before : int
            Number of real runs so far, initial ones included.
        """
        if self.change_after is not None and runs_before >= self.change_after:
            return self.changed_is1
        return self.is1

    @property
    def content_hashes(self) -> dict[str, str]:
        """Content hash by source; empty where the behaviour of the source is unknown."""
        real = self.is1.content_hash if self.is1 is not None else ""
        changed = {"IS1 changed": self.changed_is1.content_hash} if self.changed_is1 else {}
        return {"IS1": real, "IS2": self.is2.content_hash, **changed}

    def close(self) -> None:
        """Close the sources that were opened here."""
        self.opened.close()


def _facts_of(twin: FmuTwin, study: StudyFile) -> dict[str, Any]:
    """What only an FMU twin knows: its box, its parameters, and which outputs are which states."""
    signal, units = twin.signal_specs().get(study.reference.signal), twin.parameter_units()
    names = {entry.variable: name for name, entry in twin.file.outputs.items()}
    states = {state: names.get(variable) for state, variable in twin.file.states.items()}
    return {
        "gains": twin.gains,
        "parameters": tuple(units),
        "units": units,
        "reference_unit": signal.unit if signal else "",
        "command": states.get("command"),
        "velocity": states.get("velocity"),
    }


def _check_plant(study: StudyFile, is1: Source | None, plant: PlantFunction | None) -> None:
    if is1 is not None and plant is not None:
        raise InputError("expected one of is1 and plant, got both; they are the same axis")
    if study.is1.recorded is not None and len(study.references) > 1:
        raise StudyFileError(
            "[is1] recorded: a grid holds one run for each gains; give one [reference]"
        )
    if (is1 is not None or plant is not None) and study.is1.change is not None:
        raise StudyFileError("[is1] change: only a plant given as twin = FILE can change")


def disturbed_ports(study: StudyFile) -> tuple[str, ...]:
    """Ports at which the disturbances of a study act, each once.

    Parameters
    ----------
    study : StudyFile
        The validated file.
    """
    acting = [one.disturbance.port for one in study.references if one.disturbance is not None]
    return tuple(dict.fromkeys(acting))


@dataclass(frozen=True)
class _Opener:
    seed: int
    folder: Path
    opened: ExitStack
    ports: tuple[str, ...] = ()

    def plant(self, section: PlantSection, reading: SignalReading | None) -> Source | None:
        """Source of the kind that the file names; None where the user asks and tells."""
        if section.twin is not None:
            return self.twin(section.twin, self.plant_parameters(section))
        if section.command is not None:
            plant = CommandPlant(
                tuple(section.command),
                self.folder,
                time_limit_s=section.time_limit,
                retries=section.retries,
                reading=reading,
            )
            plant.check()
            return plant
        if section.function is not None:
            return PythonPlant(
                load_function(section.function, self.folder, "[is1] function"), reading
            )
        if section.recorded is not None:
            return RecordedGrid.open(self.folder / section.recorded, reading)
        return None

    def plant_parameters(self, section: PlantSection) -> dict[str, float | Literal["seed"]]:
        hidden = section.hidden.drawn(self.seed) if section.hidden is not None else {}
        return {**section.parameters, **hidden}

    def loop_twins(self, twin: FmuTwin) -> tuple[FmuTwin, FmuTwin]:
        """The twin with its command port driven, stepped finely and at its own step."""
        from gmfbo.sources.twin.twin import FmuTwin

        ports = tuple(dict.fromkeys([*self.ports, COMMAND_PORT]))
        steps = (twin.step / FINER, twin.step)
        fine, coarse = (
            FmuTwin(
                twin.path,
                parameters={**twin.parameters, **twin.texts},
                step=step,
                driven_ports=ports,
            )
            for step in steps
        )
        self.opened.callback(fine.close)
        self.opened.callback(coarse.close)
        return fine, coarse

    def twin(self, path: str, parameters: Mapping[str, float | Literal["seed"]]) -> FmuTwin:
        from gmfbo.sources.twin.twin import FmuTwin

        values = {
            name: float(self.seed) if value == "seed" else value
            for name, value in parameters.items()
        }
        twin = FmuTwin(self.folder / path, parameters=values, driven_ports=self.ports)
        self.opened.callback(twin.close)
        return twin


def run_source(source: Source, gains: Mapping[str, float], reference: Recording) -> Recording:
    """Run one experiment; an exception of the source becomes a failed run.

    Returns
    -------
    Recording
        Of status `failed` and without signals where the source raised.

    Raises
    ------
    InputError
        The request is impossible for the source, so that repeating it cannot help.
    NotTheGainsError
        The run failed for another reason than its gains.
    """
    started = time.perf_counter()
    try:
        return source.run(gains, reference)
    except (InputError, NotTheGainsError):
        raise
    except Exception as error:
        # A plant is foreign code: a lost connection must cost one run, not the study.
        reason = str(error) if isinstance(error, SimulationError) else f"{error!r}"
        return Trajectory(
            time=reference.time[:1],
            signals={},
            name=source.name,
            status="failed",
            message=" ".join(reason.split()),
            stopped_at=float(reference.time[0]),
            seconds=time.perf_counter() - started,
        )
