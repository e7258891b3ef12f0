"""Figures of a diagnosis: what they draw, and what they refuse."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from gmfbo.errors import InputError
from gmfbo.reports.figures.diagnosis_figures import before_and_after, error_table, latent_shape
from tests.diagnosis.example_diagnoses import FIT, friction, nothing, outside

pytest.importorskip("matplotlib")


def test_before_and_after_draws_each_signal_and_its_error() -> None:
    made = friction()
    figure = before_and_after(made)
    assert len(figure.axes) == 2 * len(made.curves)
    torque = made.curves[1]
    error = figure.axes[3].get_lines()[0]
    np.testing.assert_array_equal(error.get_xdata(), torque.time)
    np.testing.assert_array_equal(error.get_ydata(), torque.recorded - torque.parameters_only)
    assert figure.axes[2].get_ylabel() == "torque command [N m]"


def test_error_bars_are_the_errors_in_percent() -> None:
    figure = error_table(friction())
    widths = [bar.get_width() for bar in figure.axes[0].patches]  # type: ignore[attr-defined]
    assert widths == pytest.approx([2.13, 1.91, 0.204, 0.183])


def test_a_model_that_was_not_scored_has_no_bar() -> None:
    assert len(error_table(nothing()).axes[0].patches) == 3


def test_the_shape_is_drawn_against_its_state() -> None:
    made = outside()
    assert made.shape is not None
    axis = latent_shape(made).axes[0]
    assert axis.get_xlabel() == "velocity [rad/s]"
    np.testing.assert_array_equal(axis.get_lines()[0].get_ydata(), made.shape.y)


@pytest.mark.parametrize("name", ["$x", "a_b^c", "<b>"])
def test_names_are_taken_literally(name: str) -> None:
    made = friction()
    curves = tuple(replace(curve, recording=name, signal=name, unit=name) for curve in made.curves)
    fit = replace(FIT, signals={name: FIT.signals["position"]})
    made = replace(made, curves=curves, fit=fit)
    for figure in (before_and_after(made), error_table(made)):
        assert "<svg" in figure._repr_svg_()  # type: ignore[attr-defined]


def test_what_cannot_be_drawn_is_refused_with_a_cure() -> None:
    with pytest.raises(InputError, match="expected a diagnosis with curves"):
        before_and_after(replace(friction(), curves=()))
    with pytest.raises(InputError, match=r"got 'x\.csv'; known are rec3\.csv"):
        before_and_after(friction(), "x.csv")
    with pytest.raises(InputError, match="verdict 'missing_physics' that has none"):
        latent_shape(friction())
    with pytest.raises(InputError, match="expected a diagnosis with scored signals"):
        error_table(replace(friction(), fit=replace(FIT, signals={})))


def test_without_matplotlib_the_cure_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "gmfbo.reports.figures.notebook_figure", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(InputError, match=r"matplotlib, which is not installed; run 'pip install"):
        error_table(friction())
