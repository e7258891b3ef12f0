"""Result files of Dymola and OpenModelica: MATLAB files with a trajectory in two tables.

`name` lists the variables; `dataInfo` says in which table, `data_1` (constants) or `data_2`, and in
which column each stands, negative where the sign is turned round. Format: Dymola User Manual,
"Saving simulation results", and the OpenModelica User's Guide. The package DyMat reads the same,
but has had no release since 2020.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.columns import Column, RecordedColumns

_UNIT = re.compile(r"\[(?P<unit>[^\]|]*)(?:\|[^\]]*)?\]\s*$")  # [rad|deg]: unit and display unit
_CONSTANTS = 1


def is_modelica_result(content: Mapping[str, Any]) -> bool:
    """Whether variables of a MATLAB file are those of a result file."""
    return {"Aclass", "name", "dataInfo", "data_1", "data_2"} <= content.keys()


def read_modelica_result(label: str, content: Mapping[str, Any]) -> RecordedColumns:
    """Read all variables: those that move as columns, the others as scalars.

    At an event the file holds two rows of one instant; the last of them counts.

    Parameters
    ----------
    label : str
        File name.
    content : mapping
        Variables of the file.

    Raises
    ------
    RecordingError
        The tables contradict each other, or hold no trajectory.
    """
    try:
        transposed = "binTrans" in "".join(_lines(content["Aclass"], transposed=False))
        names = _lines(content["name"], transposed=transposed)
        told = _lines(content.get("description", []), transposed=transposed)
        where = _upright(content["dataInfo"], transposed)[:, :2].astype(int)
        tables = [_upright(content[f"data_{k}"], transposed) for k in (1, 2)]
        columns, scalars = _columns(names, told, where, tables)
    except (ValueError, IndexError, TypeError) as error:
        raise RecordingError(
            f"{label}: expected a result file of Dymola or OpenModelica, got one whose tables do "
            f"not fit ({error}); simulate again"
        ) from None
    if len(columns) < 2:
        raise RecordingError(
            f"{label}: expected variables that change with time, got none; store more variables"
        )
    last = np.append(np.diff(columns[0].values) != 0.0, True)
    kept = [Column(c.name, c.values[last], c.unit) for c in columns]
    return RecordedColumns(label=label, columns=tuple(kept), scalars=scalars)


def _columns(
    names: list[str],
    told: list[str],
    where: NDArray[np.int_],
    tables: list[NDArray[np.float64]],
) -> tuple[list[Column], dict[str, float]]:
    constants, trajectory = tables
    columns = [Column("time", trajectory[:, 0].copy(), "s")]
    scalars: dict[str, float] = {}
    for k, (name, (table, place)) in enumerate(zip(names, where.tolist(), strict=True)):
        if name.lower() == "time":
            continue
        sign = -1.0 if place < 0 else 1.0
        source = constants if table == _CONSTANTS else trajectory
        values = sign * source[:, abs(place) - 1]
        if table == _CONSTANTS:
            scalars[name] = float(values[0])
            continue
        unit = _UNIT.search(told[k]) if k < len(told) else None
        columns.append(Column(name, values, unit["unit"].strip() if unit else ""))
    return columns, scalars


def _lines(value: Any, *, transposed: bool) -> list[str]:
    """Texts of a matrix of characters, one in each row, or in each column where transposed."""
    rows = [str(row) for row in np.atleast_1d(np.asarray(value, dtype=object)).reshape(-1)]
    if transposed:
        width = max(map(len, rows), default=0)
        rows = ["".join(letters) for letters in zip(*(r.ljust(width) for r in rows), strict=True)]
    return [row.replace("\0", " ").strip() for row in rows]


def _upright(value: Any, transposed: bool) -> NDArray[np.float64]:
    """A table with a variable in each column."""
    table = np.atleast_2d(np.asarray(value, dtype=np.float64))
    return table.T if transposed else table
