"""Figures of a diagnosis, for a notebook or a paper; they need matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gmfbo.diagnosis.page.charts import recordings_to_show
from gmfbo.errors import InputError
from gmfbo.plain_words import percent, words
from gmfbo.reports.figures.figure_style import (
    BLUE,
    GREY,
    ORANGE,
    VERMILION,
    axis_label,
    in_style,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gmfbo.diagnosis import Diagnosis
    from gmfbo.diagnosis.result.curve import Curve


@in_style
def before_and_after(diagnosis: Diagnosis, recording: str | None = None) -> Figure:
    """Draw each signal of a recording, and its error, with and without the physics.

    Parameters
    ----------
    diagnosis : Diagnosis
        With curves: fresh from `diagnose`, not read from a file.
    recording : str, optional
        Name of a recording; the held-out one with most improvement unless given.

    Returns
    -------
    matplotlib.figure.Figure
        A row for each signal: the signal on the left, its error on the right.

    Raises
    ------
    InputError
        There are no curves, or none of that recording; or matplotlib is missing.
    """
    names = recordings_to_show(diagnosis)
    if not names:
        raise InputError(
            "expected a diagnosis with curves, got one without, as one read from diagnosis.json "
            "is; plot the one that diagnose() returned"
        )
    chosen = recording or names[0]
    curves = [curve for curve in diagnosis.curves if curve.recording == chosen]
    if not curves:
        raise InputError(
            f"expected a recording that was diagnosed, got '{chosen}'; known are {', '.join(names)}"
        )
    figure = new_figure(12.0, 3.0 * len(curves))
    axes = figure.subplots(len(curves), 2, sharex=True, squeeze=False)
    for row, curve in zip(axes, curves, strict=True):
        _draw_signal(row[0], curve)
        _draw_error(row[1], curve)
        for window in diagnosis.location.times:
            if window.recording == chosen:
                row[1].axvspan(window.start, window.end, color=ORANGE, alpha=0.25, linewidth=0)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    unseen = "unseen by the fit" if chosen in diagnosis.fit.held_out else "fitted on"
    figure.suptitle(f"{chosen}, {unseen}", parse_math=False)
    return figure


@in_style
def latent_shape(diagnosis: Diagnosis) -> Figure:
    """Draw the inferred signal of an unnamed mismatch, with its 95 % band.

    Parameters
    ----------
    diagnosis : Diagnosis
        With the verdict `outside_library`.

    Returns
    -------
    matplotlib.figure.Figure
        The signal against the state that it depends on.

    Raises
    ------
    InputError
        The diagnosis has no shape; or matplotlib is missing.
    """
    shape = diagnosis.shape
    if shape is None:
        raise InputError(
            f"expected a diagnosis with an inferred shape, got one of the verdict "
            f"'{diagnosis.verdict}' that has none; plot before_and_after instead"
        )
    figure = new_figure(7.0, 4.0)
    axis = figure.subplots()
    axis.fill_between(shape.x, shape.y_low, shape.y_high, color=BLUE, alpha=0.2, linewidth=0)
    axis.plot(shape.x, shape.y, color=BLUE)
    axis.set_xlabel(axis_label(words(shape.against), shape.unit_x))
    axis.set_ylabel(axis_label(f"missing at the {words(shape.port)} port", shape.unit_y))
    return figure


@in_style
def error_table(diagnosis: Diagnosis) -> Figure:
    """Draw the errors on held-out recordings as bars, with their values.

    Parameters
    ----------
    diagnosis : Diagnosis
        With at least one signal in its fit.

    Returns
    -------
    matplotlib.figure.Figure
        Bars for each signal on an axis of its own, from zero.

    Raises
    ------
    InputError
        No signal was scored; or matplotlib is missing.
    """
    signals = diagnosis.fit.signals
    if not signals:
        raise InputError("expected a diagnosis with scored signals, got none; plot its shape")
    models = (
        ("nominal", "nominal", GREY),
        ("parameters only", "parameters_only", VERMILION),
        ("augmented", "augmented", BLUE),
        ("noise floor", "noise_floor", ORANGE),
    )
    figure = new_figure(8.0, 0.6 + 1.6 * len(signals))
    axes = figure.subplots(len(signals), 1, squeeze=False)[:, 0]
    for axis, (name, fit) in zip(axes, signals.items(), strict=True):
        known = [(*model, float(getattr(fit, model[1]))) for model in models]
        known = [model for model in known if np.isfinite(model[3])]
        labels, _, colours, errors = zip(*known, strict=True) if known else ((), (), (), ())
        bars = axis.barh(labels, [100.0 * error for error in errors], color=colours)
        axis.bar_label(bars, [percent(error) for error in errors], padding=3, fontsize=9)
        axis.invert_yaxis()
        axis.margins(x=0.12)
        axis.set_title(words(name), loc="left", fontsize=10, parse_math=False)
    axes[-1].set_xlabel("RMS error over the recorded range, unseen recordings [%]")
    return figure


def _draw_signal(axis: Axes, curve: Curve) -> None:
    axis.plot(curve.time, curve.recorded, color="black", alpha=0.5, linewidth=2, label="recorded")
    axis.plot(curve.time, curve.nominal, color=GREY, linestyle=":", label="nominal")
    axis.plot(curve.time, curve.augmented, color=BLUE, label="augmented")
    axis.set_ylabel(axis_label(words(curve.signal), curve.unit), parse_math=False)
    axis.legend(loc="best", fontsize=8)


def _draw_error(axis: Axes, curve: Curve) -> None:
    before = curve.recorded - curve.parameters_only
    axis.plot(curve.time, before, color=VERMILION, linestyle="--", label="parameters only")
    axis.plot(curve.time, curve.recorded - curve.augmented, color=BLUE, label="augmented")
    axis.set_ylabel(axis_label("error", curve.unit), parse_math=False)
    axis.legend(loc="best", fontsize=8)
