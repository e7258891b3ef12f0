"""The cost between runs: through them, and nothing where none was."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.pages.shaded_map import SHADES, shade_levels, shaded_cells
from gmfbo.reports.study.interpolated_objective import InterpolatedObjective
from gmfbo.reports.study.review import StudyReview
from tests.reports.study.example_studies import write_example_study


@pytest.mark.parametrize("gains", [2, 3])
def test_it_goes_through_the_runs_and_not_beyond_them(tmp_path: Path, gains: int) -> None:
    review = StudyReview.read(write_example_study(tmp_path, gains=gains))
    between = InterpolatedObjective.of(review)
    assert between is not None
    runs = review.twin_runs if between.source == "IS2" else review.real
    succeeded = [run for run in runs if run.trial.status == "ok"]
    points = review.points(succeeded)
    costs = [run.trial.objective for run in succeeded]
    assert between.at(points) == pytest.approx(costs, abs=1e-2)
    assert np.isfinite(between.at(points.mean(axis=0, keepdims=True))).all()
    beyond = points.copy()
    beyond[:, 0] = points[:, 0].max() + 1e-3
    assert np.isnan(between.at(beyond)).all()


def test_cells_without_a_value_are_not_drawn() -> None:
    values = np.arange(100.0).reshape(10, 10)
    values[3:, :5] = np.nan
    drawn = "".join(shaded_cells(values, shade_levels(values)))
    whole = "".join(shaded_cells(np.nan_to_num(values), shade_levels(np.nan_to_num(values))))
    assert drawn.count("cell") == SHADES
    assert _area(drawn) == pytest.approx(0.65 * _area(whole), rel=0.02)


def _area(paths: str) -> float:
    parts = [part.split("v") for part in paths.split("h")[1:] if "v" in part]
    return sum(float(wide) * float(rest.partition("h")[0]) for wide, rest in parts)
