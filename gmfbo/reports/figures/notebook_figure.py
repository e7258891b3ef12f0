"""A matplotlib figure that a notebook shows by itself, without pyplot's global state."""

from __future__ import annotations

import io

from matplotlib.figure import Figure


class NotebookFigure(Figure):
    """A figure that draws itself as SVG where a notebook asks for it."""

    def _repr_svg_(self) -> str:
        drawing = io.StringIO()
        self.savefig(drawing, format="svg", bbox_inches="tight")
        return drawing.getvalue()
