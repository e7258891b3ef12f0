"""Style and writing of figures for papers; they need matplotlib."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec

from gmfbo.errors import InputError
from gmfbo.files.durable import cause
from gmfbo.units import unit_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito (2008): distinguishable with every kind of colour vision.
BLUE, VERMILION, ORANGE, GREEN = "#0072b2", "#d55e00", "#e69f00", "#009e73"
PURPLE, GREY = "#7f3fbf", "#8a929c"

METHOD_COLOURS = (BLUE, VERMILION, GREEN, "#cc79a7", "#56b4e9", "#8c6d00", PURPLE, "#555555")
"""Of methods in order; distinguishable for colour-blind readers, darkened for lines."""

DASHES = ("-", "--", "-.", ":")
"""Line styles of methods beyond the number of colours."""

FORMATS = (".pdf", ".svg", ".png")
"""Endings supported by `save_figure`."""

# Text stays text, and the same data gives the same bytes.
_STYLE: Mapping[str, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "gmfbo",
    "pdf.fonttype": 42,
    "font.size": 9.0,
    "axes.grid": True,
    "grid.linewidth": 0.4,
    "grid.alpha": 0.5,
}
_NO_DATE: Mapping[str, Mapping[str, None]] = {
    ".pdf": {"CreationDate": None},
    ".svg": {"Date": None},
    ".png": {},
}

_P = ParamSpec("_P")


def in_style(draw: Callable[_P, Figure]) -> Callable[_P, Figure]:
    """Let a function draw in the style of all figures.

    Returns
    -------
    callable
        The function in that style; it raises `InputError` where matplotlib is missing.
    """

    @wraps(draw)
    def styled(*args: _P.args, **kwargs: _P.kwargs) -> Figure:
        with _context():
            return draw(*args, **kwargs)

    return styled


def new_figure(wide: float, high: float) -> Figure:
    """Make an empty figure, which a notebook shows by itself.

    Parameters
    ----------
    wide, high : float
        [inch]

    Raises
    ------
    InputError
        matplotlib is missing.
    """
    try:
        from gmfbo.reports.figures.notebook_figure import NotebookFigure
    except ImportError:
        raise _missing() from None
    return NotebookFigure(figsize=(wide, high), layout="constrained")


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a figure; the same figure gives the same bytes.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        Figure to write.
    path : Path
        Its ending, one of `FORMATS`, decides the format.

    Raises
    ------
    InputError
        The ending is unknown, or the file cannot be written.
    """
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise InputError(f"expected a figure's name to end in {', '.join(FORMATS)}, got '{path}'")
    image = io.BytesIO()
    with _context():
        figure.savefig(image, format=kind[1:], dpi=150, metadata=dict(_NO_DATE[kind]))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(image.getvalue())
    except OSError as error:
        raise InputError(f"cannot write the figure '{path}': {cause(error)}") from None
    return path


def axis_label(what: str, unit: str) -> str:
    """Quantity with its unit; "1" where it has none."""
    return f"{what} [{unit_words(unit) or '1'}]"


def count_along(*panels: Axes) -> None:
    """Number the x axis of panels by whole numbers alone."""
    from matplotlib.ticker import MaxNLocator

    for axes in panels:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))


def gain_label(name: str, unit: str = "") -> str:
    """Label of a gain with its unit; where none is known, with the FMU's."""
    return f"{name} [{unit or 'unit of the FMU'}]"


def _context() -> Any:
    try:
        import matplotlib as mpl
    except ImportError:
        raise _missing() from None
    style: Any = dict(_STYLE)  # matplotlib's stubs list each key
    return mpl.rc_context(style)


def _missing() -> InputError:
    return InputError(
        "a figure needs matplotlib, which is not installed; run "
        "'pip install \"gmfbo[figures]\"', or open report.html or a page of 'gmfbo report'"
    )
