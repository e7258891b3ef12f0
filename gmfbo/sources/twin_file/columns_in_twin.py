"""Write `[columns]` into the text of a twin file, and leave every other line as it is."""

from __future__ import annotations

from collections.abc import Mapping

import tomlkit
from tomlkit.items import InlineTable, Table

from gmfbo.recordings.columns.column_mapping import MappedColumn
from gmfbo.sources.twin_file.column_file import guess_line, written_entry


def with_columns(
    text: str, columns: Mapping[str, MappedColumn], dialect: str, guesses: Mapping[str, str]
) -> str:
    """Text of a twin file with these columns; its comments and its order are kept.

    Parameters
    ----------
    text : str
        Of a twin file that loads. Where it names a mapping file, the table takes its place.
    columns : mapping of str to MappedColumn
        Columns by name; entries of other names stay.
    dialect : str
        How the logger's text files are written.
    guesses : mapping of str to str
        Columns by name that are written as comments.
    """
    file = tomlkit.parse(text)
    if not isinstance(file.get("columns"), Table | InlineTable):
        file.pop("columns", None)  # the name of a mapping file
        table = tomlkit.table()
        table.comment("signal, FMU parameter or time = column of the logger's files")
        file.append("columns", table)
    if dialect != file.get("dialect", "auto"):
        file["dialect"] = dialect
    entries = file["columns"]
    assert isinstance(entries, Table | InlineTable)
    for name, entry in columns.items():
        value = tomlkit.value(written_entry(entry))
        if entries.get(name) != value:
            entries[name] = value
    lines = [guess_line(name, column) for name, column in guesses.items()]
    if isinstance(entries, Table):
        for line in lines:
            if line not in text:
                entries.add(tomlkit.comment(line.removeprefix("# ")))
    return tomlkit.dumps(file)
