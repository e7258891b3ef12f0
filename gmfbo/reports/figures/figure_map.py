"""Draw a map of values over two gains, for a paper's figure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_map(
    axes: Axes,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    values: NDArray[np.float64],
    title: str,
    colours: str,
) -> None:
    """Draw values over two gains with their scale beside them.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Panel of the map.
    x, y : ndarray, shape (n,) and (m,)
        [unit of the gain]
    values : ndarray, shape (n, m)
        Mapped values; NaN, which is left white, where none is known.
    title : str
        Quantity with its unit.
    colours : str
        A colour map of matplotlib.
    """
    from matplotlib.colors import BoundaryNorm

    # Costs rise steeply at the box's edge; levels by rank show the valley too.
    levels = np.unique(np.nanquantile(values, np.linspace(0.0, 1.0, 16)))
    if levels.size < 3:
        levels = np.linspace(levels[0] - 0.5, levels[-1] + 0.5, 3)
    norm = BoundaryNorm(levels.tolist(), 256)
    filled = axes.contourf(x, y, values.T, levels=levels, cmap=colours, norm=norm)
    axes.figure.colorbar(filled, ax=axes, format="%.3g", ticks=levels[::3].tolist())
    axes.set_title(title, fontsize=9.0)
    axes.grid(visible=False)
