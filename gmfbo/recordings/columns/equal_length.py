"""Arrays by name become columns: vectors as long as the clock, and scalars."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.columns import Column, RecordedColumns, find_clock, has_clock


def columns_of_equal_length(
    label: str, arrays: Mapping[str, Any], units: Mapping[str, str]
) -> RecordedColumns:
    """Sort arrays into columns and scalars.

    Parameters
    ----------
    label : str
        File name.
    arrays : mapping of str to array_like
        Only real numbers count; vectors may be (n,), (n, 1) or (1, n).
    units : mapping of str to str
        As written.

    Returns
    -------
    RecordedColumns
        A vector of another length than the clock is a faulty column: an error if it is needed.
        Without a clock, the commonest length counts.

    Raises
    ------
    RecordingError
        There is no vector.
    """
    scalars: dict[str, float] = {}
    vectors: list[Column] = []
    for name, value in arrays.items():
        array = np.asarray(value)
        if array.dtype.kind not in "biuf":
            continue
        if array.size == 1:
            scalars[name] = float(array.reshape(-1)[0])
        elif array.size == max(array.shape, default=0):
            values = array.reshape(-1).astype(np.float64)
            vectors.append(Column(name, values, units.get(name, "")))
    if not vectors:
        found = ", ".join(list(arrays)[:8]) or "nothing"
        raise RecordingError(
            f"{label}: expected vectors of equal length, one of them 'time' or 't', got {found}; "
            "save each signal as a vector of its own"
        )
    # Without a clock the twin file may state the time between rows.
    timed = has_clock(tuple(vectors))
    rows = (
        find_clock(label, tuple(vectors)).values.size
        if timed
        else Counter(column.values.size for column in vectors).most_common(1)[0][0]
    )
    columns = []
    for column in vectors:
        if column.values.size == rows:
            columns.append(column)
        else:
            fault = (
                f"{label}: '{column.name}' has {column.values.size} values, expected {rows} as "
                f"{'the clock has' if timed else 'most others have'}; save them on one clock, "
                "NaN where not sampled"
            )
            columns.append(Column(column.name, np.full(rows, np.nan), column.unit, fault))
    return RecordedColumns(label=label, columns=tuple(columns), scalars=scalars)
