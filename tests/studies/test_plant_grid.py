"""The truth over the box, against single runs of the real FMU."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import qmc

from gmfbo import FmuTwin, Study, step_reference
from gmfbo.errors import StudyFileError
from gmfbo.objective.metrics import METRICS, step_metrics
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.studies.plant_grid import TrueSources, grid_points
from tests.studies.small_study import write_small_study


def test_grid_of_two_gains_is_regular_and_holds_the_corners() -> None:
    points = grid_points(2, 5)
    assert points.shape == (25, 2)
    assert {(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (0.25, 0.5)} <= set(
        map(tuple, points.tolist())
    )


@pytest.mark.parametrize("gains", [1, 3, 6])
def test_other_boxes_get_as_many_points_evenly(gains: int) -> None:
    points = grid_points(gains, 12)
    assert points.shape[0] >= 144
    assert points.min() >= 0.0
    assert points.max() <= 1.0
    drawn = np.random.default_rng(0).random(points.shape)
    assert qmc.discrepancy(points) < qmc.discrepancy(drawn)


def test_grid_is_what_single_runs_come_to(tmp_path: Path) -> None:
    study = Study.read(write_small_study(tmp_path))
    opened = TrueSources.open(study)
    with closing(opened.sources):
        grid = opened.grid(opened.plants[0], 4, tmp_path / "truth")
    assert grid.names == ("kp", "kv")
    reference = step_reference(0.01, at=0.05, horizon=0.4, unit="m")
    with FmuTwin(models_folder() / "linear_axis.toml") as twin:
        for row in (0, 6, 15):
            gains = dict(zip(grid.names, map(float, grid.points[row]), strict=True))
            run = twin.run(gains, reference)
            metrics = step_metrics(
                run.time, run.signal("position"), step_time=0.05, step_size=0.01, horizon=0.4
            )
            for name in METRICS:
                assert grid.metrics[name][row] == pytest.approx(float(metrics[name]), rel=1e-9)


def test_grid_is_simulated_once_and_again_where_the_plant_is_another(tmp_path: Path) -> None:
    change = 'change = { after_runs = 3, parameters = { "viscous_friction" = 900.0 } }'
    study = Study.read(write_small_study(tmp_path, change=change))
    truth = tmp_path / "truth"
    opened = TrueSources.open(study)
    with closing(opened.sources):
        before, after = opened.plants
        first = opened.grid(before, 3, truth)
        made = (truth / opened.file_name(before, 3)).stat().st_mtime_ns
        again = opened.grid(before, 3, truth)
        assert (truth / opened.file_name(before, 3)).stat().st_mtime_ns == made
        changed = opened.grid(after, 3, truth)
    assert len(list(truth.iterdir())) == 2
    np.testing.assert_array_equal(first.metrics["rise_time"], again.metrics["rise_time"])
    assert not np.array_equal(first.metrics["rise_time"], changed.metrics["rise_time"])


def test_plant_that_cannot_be_run_all_over_the_box_is_refused(tmp_path: Path) -> None:
    path = write_small_study(tmp_path)
    text = path.read_text(encoding="utf-8")
    head, tail = text.split("[is2]")
    path.write_text(head.split("[is1]")[0] + "[is1]\nask_tell = true\n[is2]" + tail)
    with pytest.raises(StudyFileError, match=r"\[is1\]: expected twin = FILE"):
        TrueSources.open(Study.read(path))
