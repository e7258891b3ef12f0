"""Oracle: on a linear plant of the model's own order the optimum follows from the first runs."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from gmfbo.studies.plant_grid import TrueSources
from gmfbo.tuning.methods import find_method
from gmfbo.tuning.tuner import Tuner
from tests.tuning.linear_study import linear_study

SECTIONS = """
[objective]
weights = { itae = 0.7, overshoot = 0.3 }
normalise = { mean = { itae = 0.0, overshoot = 0.0 }, std = { itae = 1e-6, overshoot = 10.0 } }
"""


@pytest.mark.slow
def test_a_linear_plant_is_at_its_optimum_after_the_initial_runs(tmp_path: Path) -> None:
    study = linear_study(tmp_path, SECTIONS, method="identify_then_optimise", iterations=1)
    with Tuner(study) as tuner:
        tuner.run()
        objective = tuner.history.objective
        found = tuner.history.of("IS1")[-1]
    opened = TrueSources.open(study)
    with closing(opened.sources):
        grid = opened.grid(opened.plants[0], 15, tmp_path)
    true = objective.value(grid.metrics)
    least, middle = float(true.min()), float(np.median(true))
    assert found.objective <= least + 0.01 * (middle - least)


def test_control_without_a_command_the_model_is_the_twin(tmp_path: Path) -> None:
    from tests.tuning.analytic_axis import AnalyticAxis, write_study

    study = write_study(tmp_path, method="identify_then_optimise", budget="iterations = 1")
    method = find_method("identify_then_optimise")
    axis, twin = AnalyticAxis(), AnalyticAxis(inertia=0.2)
    with Tuner(study, is1=axis, is2=twin, method=method) as tuner:
        while (request := tuner.ask()) is not None:
            note = request.note
            reference = tuner.experiment.reference
            tuner.tell(request, axis.run(request.gains, reference))
    assert note == "optimum of the model"
