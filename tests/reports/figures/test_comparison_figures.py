"""Figures of a comparison: what stands in them, and that they repeat."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.reports.comparison.curves import Curve, Landscape

pytest.importorskip("matplotlib")
from gmfbo.reports.figures.comparison_figures import (
    best_observed,
    draw_comparison,
    landscape_figure,
    sampling_cost,
)
from gmfbo.reports.figures.figure_style import save_figure


def curve(method: str, name: str) -> Curve:
    x = np.arange(1.0, 6.0)
    mean = 1.0 / x
    return Curve(method, name, x, mean, 0.9 * mean, 1.1 * mean, seeds=3)


CURVES = [curve(f"method_{k}", name) for k in range(12) for name in ("objective", "regret", "cost")]
X, Y = np.linspace(30.0, 200.0, 6), np.linspace(2.0, 10.0, 5)
COSTS = (X[:, None] / 200.0 - 0.7) ** 2 + (Y / 10.0 - 0.4) ** 2
LANDSCAPE = Landscape(("ctl.Kp", "ctl.Kd"), X, Y, COSTS, 100.0 * COSTS, seed=4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("figures")
    draw_comparison(CURVES, LANDSCAPE, made)
    return made


def test_every_method_and_axis_is_named(folder: Path) -> None:
    drawn = {path.stem: path.read_text(encoding="utf-8") for path in folder.glob("*.svg")}
    assert set(drawn) == {"landscape", "sampling_cost", "best_observed"}
    for name in ("sampling_cost", "best_observed"):
        for number in range(12):
            assert drawn[name].count(f">method_{number} (3)<") == 1
    assert ">ctl.Kp [unit of the FMU]<" in drawn["landscape"]
    assert ">ctl.Kd [unit of the FMU]<" in drawn["landscape"]
    assert "real runs, initial ones counted" in drawn["best_observed"]


def test_each_figure_is_there_in_three_formats(folder: Path) -> None:
    assert len(list(folder.iterdir())) == 9
    for ending, start in (("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")):
        for path in folder.glob(f"*.{ending}"):
            assert path.read_bytes().startswith(start), path


def test_without_a_landscape_the_others_are_drawn(tmp_path: Path) -> None:
    drawn = draw_comparison(CURVES[:3], None, tmp_path)
    assert sorted(path.stem for path in drawn) == ["best_observed", "sampling_cost"]


def test_flat_landscape_can_be_drawn(tmp_path: Path) -> None:
    flat = Landscape(("a", "b"), X, Y, np.zeros((6, 5)), np.zeros((6, 5)), seed=0)
    assert save_figure(landscape_figure(flat), tmp_path / "flat.svg").stat().st_size > 1000


@pytest.mark.parametrize("name", ["x.svg", "x.pdf"])
def test_same_table_gives_the_same_bytes(tmp_path: Path, name: str) -> None:
    first, again = (
        save_figure(landscape_figure(LANDSCAPE), tmp_path / place / name).read_bytes()
        for place in ("a", "b")
    )
    assert first == again


def test_lines_and_bands_are_those_of_the_curves() -> None:
    (axes,) = sampling_cost(CURVES).axes
    costs = [one for one in CURVES if one.name == "cost"]
    assert len(axes.get_lines()) == len(axes.collections) == len(costs)
    for line, band, one in zip(axes.get_lines(), axes.collections, costs, strict=True):
        np.testing.assert_array_equal(line.get_xdata(), one.x)
        np.testing.assert_array_equal(line.get_ydata(), one.mean)
        edge = band.get_paths()[0].vertices
        assert {*one.low, *one.high} <= {*np.asarray(edge)[:, 1]}


def test_no_two_methods_look_the_same() -> None:
    (axes,) = sampling_cost(CURVES).axes
    looks = {(line.get_color(), line.get_linestyle()) for line in axes.get_lines()}
    assert len(looks) == 12


def test_the_star_stands_on_the_best_gains_of_the_plant() -> None:
    row, column = np.unravel_index(np.argmin(COSTS), COSTS.shape)
    for axes in landscape_figure(LANDSCAPE).axes[:2]:
        np.testing.assert_array_equal(axes.get_lines()[0].get_xydata(), [[X[row], Y[column]]])


def test_every_axis_has_a_unit() -> None:
    for figure in (sampling_cost(CURVES), best_observed(CURVES), landscape_figure(LANDSCAPE)):
        for axes in figure.axes:
            for label in (axes.get_xlabel(), axes.get_ylabel()):
                # Panels share an axis; a scale has its quantity in the title of its map.
                assert not label or ("[" in label and label.endswith("]")), label
