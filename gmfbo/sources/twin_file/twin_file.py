"""The twin file: names an FMU's variables in the recording's words."""

from __future__ import annotations

from pathlib import Path
from typing import Self

from pydantic import Field, ValidationError, field_validator, model_validator

from gmfbo.errors import TwinFileError, did_you_mean
from gmfbo.files.toml_text import parse_toml, read_toml_text
from gmfbo.sources.twin_file.column_file import (
    ColumnEntry,
    ColumnFile,
    Dialect,
    only_time_is_counted,
)
from gmfbo.sources.twin_file.entries import (
    CONTROLLER_KINDS,
    ControllerEntry,
    FixedNames,
    GainRange,
    InputEntry,
    LimitsTable,
    NotNegative,
    Number,
    OutputEntry,
    Pair,
    ParameterValue,
    Positive,
    RecordingTable,
    SignalEntry,
    StopTime,
    Table,
    TableEntry,
    Text,
)
from gmfbo.sources.twin_file.pydantic_message import describe_problems

__all__ = [
    "KNOWN_STATES",
    "ControllerEntry",
    "GainRange",
    "InputEntry",
    "OutputEntry",
    "SignalEntry",
    "TableEntry",
    "TwinFile",
    "twin_files",
]

KNOWN_STATES = (
    "position",
    "velocity",
    "command",
    "current",
    "voltage",
    "load_torque",
    "load_position",
    "temperature",
)


class TwinFile(Table):
    """A validated twin file; paths in it are relative to its folder.

    Attributes
    ----------
    name : str
        Name for messages.
    fmu : str or None
        Path of the FMU; None where `fmus` is given.
    fmus : dict of str to str or ControllerEntry
        FMUs by the prefix of their variables, in order of computation.
    wires : dict of str to str
        FMU input = FMU output.
    step : float
        [s] Communication step.
    warmup : float or None
        [s] Start of a run that is simulated, but not scored.
    inputs, outputs : dict
        Recorded signal = FMU variable.
    parameters : dict of str to float
        Values set before initialisation.
    gains : dict of str to GainRange
        Ranges of the gains that tuning may move.
    uncertain : dict of str to tuple of float
        Ranges [low, high] of uncertain parameters.
    fixed : FixedNames
        Parameters that are known for certain: a diagnosis never doubts them.
    tables : dict of str to TableEntry
        Uncertain lookup tables, by a name for messages.
    ports, states, roles : dict of str to str
        FMU inputs where physics may act, outputs that it may depend on, parameters with a role.
    initial : dict of str to str or float
        FMU parameter = recorded signal, number, or "fit".
    columns : dict of str to ColumnEntry
        Signal, FMU parameter or `time` = column of the logger's files; in the file a table, or
        the path of a file that holds it.
    dialect : str
        How the logger's text files are written.
    recording : RecordingTable
        How recordings are followed.
    limits : LimitsTable
        What a run may cost.
    words : dict of str to str
        Entries of [parameters] that are texts: a text, true or false, or an enumeration's item.
    stop_time : bool or float
        [s] Stop time that is announced to the FMUs; True for the end of each run and one step.
    time_limit : float or None
        [s] Wall-clock time of one run; None for 10 s and 20 times its simulated time.
    origin : str or None
        Path of the twin file from which an augmented twin was made; no run depends on it.
    """

    name: Text
    fmu: Text | None = None
    fmus: dict[str, Text | ControllerEntry] = Field(default_factory=dict)
    wires: dict[str, Text] = Field(default_factory=dict)
    step: Positive
    warmup: NotNegative | None = None
    inputs: dict[str, InputEntry] = Field(default_factory=dict)
    outputs: dict[str, OutputEntry]
    parameters: dict[str, ParameterValue] = Field(default_factory=dict)
    gains: dict[str, GainRange] = Field(default_factory=dict)
    uncertain: dict[str, Pair] = Field(default_factory=dict)
    fixed: FixedNames = Field(default_factory=FixedNames)
    tables: dict[str, TableEntry] = Field(default_factory=dict)
    ports: dict[str, Text] = Field(default_factory=dict)
    states: dict[str, Text] = Field(default_factory=dict)
    roles: dict[str, Text] = Field(default_factory=dict)
    initial: dict[str, Number | Text] = Field(default_factory=dict)
    columns: dict[str, ColumnEntry] = Field(default_factory=dict)
    dialect: Dialect = "auto"
    recording: RecordingTable = Field(default_factory=RecordingTable)
    limits: LimitsTable = Field(default_factory=LimitsTable)
    words: dict[str, str] = Field(default_factory=dict)
    stop_time: StopTime = False
    time_limit: Positive | None = None
    origin: Text | None = None

    @model_validator(mode="before")
    @classmethod
    def _words_apart(cls, value: object) -> object:
        if not isinstance(value, dict) or not isinstance(value.get("parameters"), dict):
            return value
        given = value["parameters"]
        words = {name: word for name, word in given.items() if isinstance(word, str)}
        numbers = {name: number for name, number in given.items() if name not in words}
        return {**value, "parameters": numbers, "words": {**value.get("words", {}), **words}}

    @field_validator("fmus", mode="before")
    @classmethod
    def _known_controllers(cls, value: object) -> object:
        # Checked here, since a union of a text and a table would report both failures.
        for name, entry in value.items() if isinstance(value, dict) else ():
            if isinstance(entry, dict) and entry.get("kind") not in CONTROLLER_KINDS:
                kind = str(entry.get("kind", ""))
                raise ValueError(
                    f"{name}: no controller kind '{kind}'" + did_you_mean(kind, CONTROLLER_KINDS)
                )
            if not isinstance(entry, dict | str):
                raise ValueError(f"{name}: expected a path or a table with kind, got {entry!r}")
            if not name or "." in name:
                raise ValueError(f"'{name}': expected a prefix without a dot")
        return value

    @field_validator("states")
    @classmethod
    def _known_states(cls, value: dict[str, str]) -> dict[str, str]:
        for name in value:
            if name not in KNOWN_STATES:
                raise ValueError(f"no state '{name}'" + did_you_mean(name, KNOWN_STATES))
        return value

    @field_validator("columns")
    @classmethod
    def _sampled_clock(cls, value: dict[str, ColumnEntry]) -> dict[str, ColumnEntry]:
        return only_time_is_counted(value)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.fmu is None) == (not self.fmus):
            raise ValueError("expected either fmu = FILE or a table [fmus]")
        if self.wires and not self.fmus:
            raise ValueError("[wires] joins the FMUs of [fmus]; with fmu = FILE there is none")
        if not self.outputs:
            raise ValueError("[outputs]: expected at least one signal to compare")
        for signal in self.inputs:
            if signal in self.outputs:
                raise ValueError(f"signal '{signal}' is in [inputs] and in [outputs]; rename one")
        return self

    @classmethod
    def parse(cls, text: str, label: str, folder: Path | None = None) -> TwinFile:
        """Read and validate the text of a twin file.

        Parameters
        ----------
        text : str
            TOML.
        label : str
            Name of the file, for messages.
        folder : Path, optional
            Folder of the file, and of a column mapping that it may name.

        Raises
        ------
        TwinFileError
            One line with each of the first few problems.
        """
        try:
            raw = parse_toml(text)
        except ValueError as error:
            raise TwinFileError(f"{label}: not valid TOML: {error}") from None
        if isinstance(raw.get("columns"), str):
            shared = ColumnFile.read((folder or Path()) / raw["columns"])
            raw["columns"] = shared.columns
            raw.setdefault("dialect", shared.dialect)
        try:
            return cls.model_validate(raw)
        except ValidationError as error:
            raise TwinFileError(f"{label}: {describe_problems(error, cls)}") from None

    @property
    def fitted_starts(self) -> tuple[str, ...]:
        """Entries of [initial] that a diagnosis fits to each recording."""
        return tuple(name for name, source in self.initial.items() if source == "fit")

    @classmethod
    def read(cls, path: str | Path) -> TwinFile:
        """Read and validate a twin file.

        Parameters
        ----------
        path : str or Path
            The `.toml` file.

        Raises
        ------
        TwinFileError
            It is missing, not UTF-8, not TOML, or no valid twin file.
        """
        path = Path(path)
        try:
            text = read_toml_text(path)
        except ValueError as error:
            why = "" if isinstance(error, UnicodeDecodeError) else f" ({error})"
            raise TwinFileError(
                f"{path.name}: expected UTF-8 text{why}; is it an FMU? give the twin file (.toml)"
            ) from None
        except OSError as error:
            raise TwinFileError(
                f"no twin file at '{path}' ({error.strerror or error}); check the path"
            ) from None
        return cls.parse(text, path.name, path.parent)


def twin_files(path: Path) -> tuple[Path, ...]:
    """A twin file and all files that it names, without those that ship with gmfbo.

    Parameters
    ----------
    path : Path
        The `.toml` file.

    Raises
    ------
    TwinFileError
        It cannot be read.
    """
    twin = TwinFile.read(path)
    named = [twin.fmu, *twin.fmus.values()]
    columns = parse_toml(read_toml_text(path)).get("columns")
    named.append(columns if isinstance(columns, str) else None)
    return (path, *(path.parent / name for name in named if isinstance(name, str)))
