"""Elements of a lookup table by their indices in FMU variable names."""

from __future__ import annotations

import re
from collections.abc import Iterable

LEAST_NODES = 3
"""Fewer nodes have no bend, so noise cannot be told from shape."""


def elements(stem: str, names: Iterable[str]) -> dict[tuple[int, ...], str]:
    """Elements `STEM[i]` or `STEM[i,j]` among names, by their indices, row by row.

    Parameters
    ----------
    stem : str
        Name without indices.
    names : iterable of str
        All that there are.
    """
    form = re.compile(re.escape(stem) + r"\[(\d+)(?:,\s*(\d+))?\]")
    found = {
        tuple(int(index) for index in match.groups() if index is not None): name
        for name in names
        if (match := form.fullmatch(name))
    }
    return dict(sorted(found.items()))


def shape_of(found: Iterable[tuple[int, ...]]) -> tuple[int, ...]:
    """Shape of the table with these indices, counted from 1; missing elements go unnoticed."""
    return tuple(map(max, zip(*found, strict=True)))
