"""Arrays by name become columns: vectors and parts of matrices as long as the clock; scalars."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.clock import is_steady
from gmfbo.recordings.columns.columns import Column, RecordedColumns, find_clock, has_clock


def columns_of_equal_length(
    label: str,
    arrays: Mapping[str, Any],
    units: Mapping[str, str],
    faults: Mapping[str, str] | None = None,
) -> RecordedColumns:
    """Sort arrays into columns and scalars.

    Parameters
    ----------
    label : str
        File name.
    arrays : mapping of str to array_like
        Only real numbers count; vectors may be (n,), (n, 1) or (1, n). A matrix becomes columns
        `NAME(:,1)` or `NAME(1,:)`, whichever are as long as the clock.
    units : mapping of str to str
        As written.
    faults : mapping of str to str, optional
        Messages about values that cannot be read, by name: faulty columns.

    Returns
    -------
    RecordedColumns
        A vector of another length than the clock is a faulty column: an error if it is needed.
        Without a clock the commonest length counts; an evenly rising first part is the time.

    Raises
    ------
    RecordingError
        There is no vector, and no matrix.
    """
    known = {n: np.asarray(a) for n, a in arrays.items() if np.asarray(a).dtype.kind in "biuf"}
    scalars = {n: float(a.reshape(-1)[0]) for n, a in known.items() if a.size == 1}
    vectors = [
        Column(n, a.reshape(-1).astype(np.float64), units.get(n, ""))
        for n, a in known.items()
        if 1 != a.size == max(a.shape, default=0)
    ]
    matrices = {n: a for n, a in known.items() if a.ndim == 2 and min(a.shape) > 1}
    if not vectors and not matrices:
        raise RecordingError(next(iter(faults.values())) if faults else _no_vectors(label, arrays))
    rows, timed = _row_count(vectors, matrices)
    columns = [column for column in vectors if column.values.size == rows]
    wrong = {c.name: f"{c.values.size} values" for c in vectors if c not in columns}
    for name, matrix in matrices.items():
        parts = matrix_columns(name, matrix, rows)
        if parts is None:
            wrong[name] = f"{' x '.join(map(str, matrix.shape))} values"
            continue
        columns += [Column(n, values, units.get(name, "")) for n, values in parts.items()]
    columns = columns if timed else _with_increasing_time(columns, matrices)
    likened = "the clock has" if timed else "most others have"
    told = {
        name: f"{label}: '{name}' has {what}, expected {rows} as {likened}; save them on one "
        "clock, NaN where not sampled"
        for name, what in wrong.items()
    }
    for name, why in {**told, **(faults or {})}.items():
        columns.append(Column(name, np.full(rows, np.nan), units.get(name, ""), why))
    return RecordedColumns(label=label, columns=tuple(columns), scalars=scalars)


def matrix_columns(
    name: str, array: NDArray[Any], rows: int
) -> dict[str, NDArray[np.float64]] | None:
    """Columns or rows of an array that have so many values, by the names that MATLAB gives them.

    Parameters
    ----------
    name : str
        Of the array.
    array : ndarray
        Vector or matrix.
    rows : int
        Values of the clock.

    Returns
    -------
    dict or None
        A vector keeps its name; None where no dimension fits.
    """
    if array.size == rows == max(array.shape, default=0):
        return {name: array.reshape(-1).astype(np.float64)}
    if array.ndim != 2 or rows not in array.shape:
        return None
    upright = array.shape[0] == rows
    table = (array if upright else array.T).astype(np.float64)
    place = "(:,{})" if upright else "({},:)"
    return {
        name + place.format(k + 1): np.ascontiguousarray(table[:, k]) for k in range(table.shape[1])
    }


def _no_vectors(label: str, arrays: Mapping[str, Any]) -> str:
    found = ", ".join(list(arrays)[:8]) or "nothing"
    return (
        f"{label}: expected vectors of equal length, one of them 'time' or 't', got {found}; "
        "save each signal as a vector of its own"
    )


def _row_count(vectors: list[Column], matrices: Mapping[str, NDArray[Any]]) -> tuple[int, bool]:
    """Values of each column, and whether a clock among the vectors says so."""
    if has_clock(tuple(vectors)):
        return find_clock("", tuple(vectors)).values.size, True
    # Without a clock the twin file may state the time between rows.
    lengths = Counter(column.values.size for column in vectors)
    lengths.update(max(matrix.shape) for matrix in matrices.values())
    return lengths.most_common(1)[0][0], False


def _with_increasing_time(
    columns: list[Column], matrices: Mapping[str, NDArray[Any]]
) -> list[Column]:
    """Columns of which the first of a matrix, if it increases evenly, is one of seconds."""
    firsts = {f"{name}{place}" for name in matrices for place in ("(:,1)", "(1,:)")}
    for k, column in enumerate(columns):
        known = column.values.size > 2 and bool(np.isfinite(column.values).all())
        if column.name in firsts and known and is_steady(column.values):
            columns[k] = replace(column, unit="s", assumed=True)
            break
    return columns
