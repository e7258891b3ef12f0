"""A column mapping in a file of its own, which several twin files may share."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Literal, Self

from pydantic import Field, ValidationError, field_validator, model_validator

from gmfbo.errors import TwinFileError
from gmfbo.files.toml_text import parse_toml, read_toml_text
from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
from gmfbo.sources.twin_file.entries import Number, Positive, Table, Text
from gmfbo.sources.twin_file.pydantic_message import describe_problems
from gmfbo.units import parse_unit

Dialect = Literal["auto", "plain", "decimal_comma", "twincat_scope"]


class ColumnEntry(Table):
    """A column of a logger's file: value [unit] = scale * column + offset.

    Attributes
    ----------
    column : str
        Its name in the file.
    unit : str or None
        Unit of the value; the unit in the file's header unless given.
    scale : float or None
        [unit / column unit]
    offset : float
        [unit]
    sample_time : float or None
        [s] Of `time` in files without a clock: time between two rows, instead of a column.
    """

    column: Text | None = None
    unit: Text | None = None
    scale: Number | None = None
    offset: Number = 0.0
    sample_time: Positive | None = None

    @model_validator(mode="before")
    @classmethod
    def _from_name(cls, value: object) -> object:
        return {"column": value} if isinstance(value, str) else value

    @model_validator(mode="after")
    def _column_or_sample_time(self) -> Self:
        if self.column is None and self.sample_time is None:
            raise ValueError("expected column = NAME")
        if self.sample_time is not None and self.model_fields_set != {"sample_time"}:
            raise ValueError("sample_time: expected it alone, it stands for a column")
        return self

    @model_validator(mode="after")
    def _known_unit(self) -> Self:
        if self.unit is not None and parse_unit(self.unit) is None:
            raise ValueError(f"unit: '{self.unit}' is not known; expected such as rad, deg or mA")
        return self


class ColumnFile(Table):
    """A validated file of a column mapping.

    Attributes
    ----------
    dialect : str
        How the logger's text files are written.
    columns : dict of str to ColumnEntry
        Signal, FMU parameter or `time` = column.
    """

    dialect: Dialect = "auto"
    columns: dict[str, ColumnEntry] = Field(default_factory=dict)

    @field_validator("columns")
    @classmethod
    def _sampled_clock(cls, value: dict[str, ColumnEntry]) -> dict[str, ColumnEntry]:
        return only_time_is_counted(value)

    @classmethod
    def read(cls, path: Path) -> ColumnFile:
        """Read and validate the file.

        Parameters
        ----------
        path : Path
            The `.toml` file.

        Raises
        ------
        TwinFileError
            It is missing, not TOML, or no valid column mapping.
        """
        try:
            raw = parse_toml(read_toml_text(path))
        except OSError as error:
            raise TwinFileError(
                f"no column mapping at '{path}' ({error.strerror or error}); check the path, or "
                "leave 'columns' out and make one with 'gmfbo columns TWIN.toml REC --save FILE'"
            ) from None
        except ValueError as error:
            raise TwinFileError(f"{path.name}: not valid TOML: {error}") from None
        try:
            return cls.model_validate(raw)
        except ValidationError as error:
            raise TwinFileError(f"{path.name}: {describe_problems(error, cls)}") from None


def only_time_is_counted(columns: dict[str, ColumnEntry]) -> dict[str, ColumnEntry]:
    """Entries unchanged; a `sample_time` elsewhere than in `time` is refused by ValueError."""
    for name, entry in columns.items():
        if entry.sample_time is not None and name != "time":
            raise ValueError(f"{name}: sample_time is for 'time' only; expected column = NAME")
    return columns


def column_mapping(columns: Mapping[str, ColumnEntry], dialect: str) -> ColumnMapping:
    """Column mapping for a reader.

    Parameters
    ----------
    columns : mapping of str to ColumnEntry
        Columns by name.
    dialect : str
        How the logger's text files are written.
    """
    return ColumnMapping(
        {
            name: MappedColumn(
                entry.column or "", entry.unit or "", entry.scale, entry.offset, entry.sample_time
            )
            for name, entry in columns.items()
        },
        dialect,
    )


def column_file_text(
    columns: Mapping[str, MappedColumn], dialect: str, guesses: Mapping[str, str], story: str
) -> str:
    """Text of a column mapping's file.

    Parameters
    ----------
    columns : mapping of str to MappedColumn
        Columns by name.
    dialect : str
        How the logger's text files are written.
    guesses : mapping of str to str
        Columns by name that are written as comments.
    story : str
        One line, for the top.

    Returns
    -------
    str
        TOML that `ColumnFile.read` reads.
    """
    lines = [f"# {' '.join(story.split())}", f"dialect = {_text(dialect)}", ""]
    lines.append("[columns]  # signal, FMU parameter or time = column of the file")
    lines += [f"{written_key(name)} = {written_entry(entry)}" for name, entry in columns.items()]
    lines += [guess_line(name, column) for name, column in guesses.items()]
    return "\n".join(lines) + "\n"


def guess_line(name: str, column: str) -> str:
    """Comment that holds a guessed entry."""
    return f"# {written_key(name)} = {_text(column)}  # a guess; remove the # if it is right"


def written_entry(entry: MappedColumn) -> str:
    """TOML value of an entry of a column mapping."""
    if entry.sample_time is not None:
        return f"{{ sample_time = {float(entry.sample_time)!r} }}"
    if not entry.converts:
        return _text(entry.column)
    pairs = [f"column = {_text(entry.column)}"]
    pairs += [f"unit = {_text(entry.unit)}"] if entry.unit else []
    pairs += [f"scale = {float(entry.scale)!r}"] if entry.scale is not None else []
    pairs += [f"offset = {float(entry.offset)!r}"] if entry.offset else []
    return "{ " + ", ".join(pairs) + " }"


def written_key(name: str) -> str:
    """TOML key of a name, in quotes where it needs them."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _text(value: str) -> str:
    """TOML basic string, whose escapes are those of JSON but for the control character DEL."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
