"""Values over two gains as a map of a few shades, small as SVG."""

from __future__ import annotations

from html import escape
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gmfbo.pages.svg_frame import HIGH, WIDE

Array = NDArray[np.float64]

SHADES = 10
"""Shades of a map; the page's style has a class for each, the lowest values first."""


def shade_levels(values: Array) -> Array:
    """Limits between shades, shape (SHADES - 1,), such that each shade has the same area.

    Costs rise steeply at the box's edge; shades by rank show the valley too.

    Parameters
    ----------
    values : ndarray, shape (n, m)
        Mapped values; NaN where none is known.
    """
    return np.asarray(np.nanquantile(values, np.linspace(0.0, 1.0, SHADES + 1)[1:-1]))


def shade_of(value: float, levels: Array) -> str:
    """Class of the shade of a value.

    Parameters
    ----------
    value : float
        Of a run, or a cell.
    levels : ndarray, shape (SHADES - 1,)
        Of `shade_levels`.
    """
    return f"s{int(np.searchsorted(levels, value))}"


def shaded_cells(values: Array, levels: Array) -> list[str]:
    """Draw a map; cells of a row that have the same shade are one rectangle.

    Parameters
    ----------
    values : ndarray, shape (n, m)
        The first gain along the first axis, which goes to the right; the second goes upwards. A
        cell without a value, NaN, is not drawn.
    levels : ndarray, shape (SHADES - 1,)
        Of `shade_levels`.

    Returns
    -------
    list of str
        A path for each shade that there is, in the drawing's units.
    """
    shade = np.where(np.isnan(values), -1, np.searchsorted(levels, values))
    columns, rows = values.shape
    wide, high = WIDE / columns, HIGH / rows
    paths: list[list[str]] = [[] for _ in range(SHADES)]
    for row in range(rows):
        along = shade[:, row]
        edges = [0, *(np.flatnonzero(np.diff(along)) + 1).tolist(), columns]
        top = round(HIGH - (row + 1) * high)
        tall = round(HIGH - row * high) - top
        for start, end in pairwise(edges):
            if along[start] < 0:
                continue
            left, right = round(start * wide), round(end * wide)
            paths[int(along[start])].append(f"M{left} {top}h{right - left}v{tall}h{left - right}Z")
    return [
        f'<path class="cell s{level}" d="{"".join(path)}"/>'
        for level, path in enumerate(paths)
        if path
    ]


def shade_scale(values: Array, levels: Array, label: str) -> str:
    """Draw the scale of a map: its shades, with the values between them.

    Parameters
    ----------
    values : ndarray, shape (n, m)
        Mapped values.
    levels : ndarray, shape (SHADES - 1,)
        Of `shade_levels`.
    label : str
        Quantity with its unit.

    Returns
    -------
    str
        An HTML figure; the lowest values are on the left.
    """
    wide = 100.0 / SHADES
    cells = "".join(
        f'<rect class="cell s{k}" x="{k * wide:g}%" y="0" width="{wide:g}%" height="12"/>'
        for k in range(SHADES)
    )
    ends = [float(np.nanmin(values)), *levels.tolist(), float(np.nanmax(values))]
    places = range(0, SHADES + 1, 2)
    texts = _scale_texts([ends[k] for k in places])
    anchors = {0: "start", SHADES: "end"}
    told = "".join(
        f'<text x="{k * wide:g}%" y="27" text-anchor="{anchors.get(k, "middle")}">{text}</text>'
        for k, text in zip(places, texts, strict=True)
    )
    return (
        f'<figure class="scale"><figcaption>{escape(label)}, low is good</figcaption>'
        f'<svg role="img" aria-label="{escape(label)}, from {texts[0]} to {texts[-1]}">'
        f"{cells}{told}</svg></figure>"
    )


def _scale_texts(values: list[float]) -> list[str]:
    """As few digits as tell neighbours apart, at least three."""
    for digits in range(3, 9):
        texts = [f"{value + 0.0:.{digits}g}" for value in values]
        if len(set(texts)) == len(set(values)):
            break
    return texts
