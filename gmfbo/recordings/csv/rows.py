"""Numbers in the rows of a text table, column by column."""

from __future__ import annotations

import numpy as np

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.columns import Column
from gmfbo.recordings.csv.numbers import with_point
from gmfbo.recordings.csv.times import read_date, read_times

_BLANK = {"", "nan", "NaN", "NAN"}


class Rows:
    """Cells below the header, with the lines on which they stand.

    Parameters
    ----------
    label : str
        File name, for messages.
    rows : list of list of str
        Cells of each line; rows without any text are left out.
    places : list of int
        Line of each row, from 1.
    separator : str
        Between cells.
    dialect : str
        One of `gmfbo.recordings.columns.column_mapping.DIALECTS`.
    """

    def __init__(
        self, label: str, rows: list[list[str]], places: list[int], separator: str, dialect: str
    ) -> None:
        self.label = label
        self.dialect = dialect
        self.separator = separator
        # A spreadsheet writes an empty line as a row of separators.
        keep = [k for k, row in enumerate(rows) if any(map(str.strip, row))]
        self.rows = [rows[k] for k in keep]
        self.places = [places[k] for k in keep]

    def check_width(self, width: int) -> None:
        for row, place in zip(self.rows, self.places, strict=True):
            if len(row) != width and (len(row) < width or any(map(str.strip, row[width:]))):
                hint = (
                    "a decimal comma needs ';' between the cells"
                    if self.separator == "," and len(row) > width
                    else "complete or delete the line"
                )
                raise RecordingError(
                    f"{self.label}, line {place}: expected {width} cells as in the header, got "
                    f"{len(row)}; {hint}"
                )

    def column(self, index: int, name: str, unit: str, *, infinite: bool) -> Column:
        """Numbers of one column; `infinite` allows infinity, which a diverged run may hold."""
        cells = [row[index].strip() for row in self.rows]
        texts = ["nan" if cell in _BLANK else cell for cell in cells]
        texts = with_point(texts, self.separator, self.dialect)
        try:
            values = np.array(texts, dtype=np.float64) if texts else np.empty(0)
            # NumPy reads 1_000 as a thousand and 1e999 as infinity.
            sound = infinite or not np.isinf(values).any()
            if sound and "_" not in "".join(texts):
                return Column(name, values, unit)
        except ValueError:
            pass
        return self._faulty(name, unit, cells, texts)

    def write_out_times(self, columns: list[Column]) -> str:
        """Convert columns of written times to seconds; returns the first one's start.

        A date in a column of its own tells the day of the start alone: times of day go on past
        midnight by themselves.
        """
        start, day = "", ""
        for index, column in enumerate(columns):
            if not column.fault or np.isfinite(column.values).any():
                continue
            texts = [row[index].strip() for row in self.rows]
            read = read_times(texts)
            if read is not None:
                columns[index] = Column(column.name, read[0], "s")
                start = start or read[1]
            day = day or read_date(texts[0])
        return start or day

    def _faulty(self, name: str, unit: str, cells: list[str], texts: list[str]) -> Column:
        values = np.full(len(cells), np.nan)
        fault = ""
        for row, text in enumerate(texts):
            number = _number(text)
            if number is not None:
                values[row] = number
            elif not fault:
                fault = (
                    f"{self.label}, line {self.places[row]}, column '{name}': expected a number, "
                    f"got '{cells[row]}'; correct the cell, or leave it blank if not sampled"
                )
        return Column(name, values, unit, fault)


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return None if "_" in text or np.isinf(value) else value
