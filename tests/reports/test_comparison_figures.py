"""Figures of a comparison: what stands in them, and that they repeat."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.reports.comparison_curves import Curve, Landscape

pytest.importorskip("matplotlib")
from gmfbo.reports.comparison_figures import draw_comparison


def curve(method: str, name: str) -> Curve:
    x = np.arange(1.0, 6.0)
    mean = 1.0 / x
    return Curve(method, name, x, mean, 0.9 * mean, 1.1 * mean, seeds=3)


CURVES = [curve(f"method_{k}", name) for k in range(12) for name in ("objective", "regret", "cost")]
X, Y = np.linspace(30.0, 200.0, 6), np.linspace(2.0, 10.0, 5)
COSTS = (X[:, None] / 200.0 - 0.7) ** 2 + (Y / 10.0 - 0.4) ** 2
LANDSCAPE = Landscape(("ctl.Kp", "ctl.Kd"), X, Y, COSTS, 100.0 * COSTS, seed=4)


def test_every_method_and_axis_is_named(tmp_path: Path) -> None:
    drawn = {path.stem: path.read_text() for path in draw_comparison(CURVES, LANDSCAPE, tmp_path)}
    assert set(drawn) == {"landscape", "sampling_cost", "best_observed"}
    for name in ("sampling_cost", "best_observed"):
        for number in range(12):
            assert drawn[name].count(f">method_{number} (3)<") == 1
    assert ">ctl.Kp<" in drawn["landscape"]
    assert ">ctl.Kd<" in drawn["landscape"]
    assert "real runs, initial ones counted" in drawn["best_observed"]
    assert all((tmp_path / f"{name}.png").stat().st_size > 1000 for name in drawn)


def test_without_a_landscape_the_others_are_drawn(tmp_path: Path) -> None:
    drawn = draw_comparison(CURVES, None, tmp_path)
    assert sorted(path.stem for path in drawn) == ["best_observed", "sampling_cost"]


def test_flat_landscape_can_be_drawn(tmp_path: Path) -> None:
    flat = Landscape(("a", "b"), X, Y, np.zeros((6, 5)), np.zeros((6, 5)), seed=0)
    assert any(path.stem == "landscape" for path in draw_comparison(CURVES, flat, tmp_path))


def test_same_tables_give_the_same_bytes(tmp_path: Path) -> None:
    first = draw_comparison(CURVES, LANDSCAPE, tmp_path / "a")
    again = draw_comparison(CURVES, LANDSCAPE, tmp_path / "b")
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in again]
