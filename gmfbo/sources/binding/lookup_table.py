"""Lookup tables inside an FMU that its twin file calls uncertain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.sources.binding.table_nodes import elements, shape_of

if TYPE_CHECKING:
    from gmfbo.sources.binding.binding import Binding


@dataclass(frozen=True, eq=False)
class LookupTable:
    """One table of a twin.

    Attributes
    ----------
    name : str
        Name for messages.
    nodes, parameters : tuple of str
        FMU variables with the table in force, and FMU parameters that change it, row by row.
    shape : tuple of int
        Of the table; one or two numbers.
    rising : int or None
        Axis along which the values do not fall.
    added : bool
        Whether the parameters are added to the table; otherwise they are the table.
    """

    name: str
    nodes: tuple[str, ...]
    parameters: tuple[str, ...]
    shape: tuple[int, ...]
    rising: int | None
    added: bool

    def settings(
        self, nodes: NDArray[np.float64], change: NDArray[np.float64], before: NDArray[np.float64]
    ) -> dict[str, float]:
        """Parameter values that change the table.

        Parameters
        ----------
        nodes, change, before : ndarray, shape (n,)
            [FMU's unit] The table in force, the wanted change, and the parameters' values in force;
            row by row.
        """
        values = before + change if self.added else nodes + change
        return dict(zip(self.parameters, map(float, values), strict=True))


def tables_of(binding: Binding) -> tuple[LookupTable, ...]:
    """Tables that a twin file names; binding has checked them."""
    tables = []
    for name, entry in binding.file.tables.items():
        found = elements(entry.nodes, binding.variables)
        moved = elements(entry.deltas or entry.nodes, binding.variables)
        tables.append(
            LookupTable(
                name=name,
                nodes=tuple(found.values()),
                parameters=tuple(moved.values()),
                shape=shape_of(found),
                rising=None if entry.rising is None else int(entry.rising == "columns"),
                added=entry.deltas is not None,
            )
        )
    return tuple(tables)
