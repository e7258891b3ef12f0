"""A study that lost trials is repaired, and goes on to the end of its budget."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import StoreError
from gmfbo.recordings.repair.repair_folder import repair_folder
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study
from tests.tuning.methods.quick_methods import QUICK


def tune(study: Study, *, resume: bool) -> None:
    twin, method = AnalyticAxis(inertia=0.2, friction=0.4), QUICK[study.file.method]
    with Tuner(study, is1=AnalyticAxis(), is2=twin, method=method, resume=resume) as tuner:
        tuner.run()


@pytest.mark.parametrize("method", ["random", "gmfbo"])
def test_a_study_goes_on_without_a_real_run_and_a_twin_run_that_were_damaged(
    tmp_path: Path, method: str
) -> None:
    tune(write_study(tmp_path, method=method, seed=2, budget="iterations = 2"), resume=False)
    longer = write_study(tmp_path, method=method, seed=2, budget="iterations = 5")
    before = {trial.number: trial for trial in longer.trials}
    real = next(trial.number for trial in longer.trials if trial.source == "IS1")
    twin = next(trial.number for trial in longer.trials if trial.source == "IS2")
    for number in (real, twin):
        path = longer.location / "trials" / f"{number:06d}.h5"
        path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(StoreError, match=r"is damaged .*; run `gmfbo repair .*axis\.study`"):
        tune(longer, resume=True)
    assert sorted(repair_folder(longer.location).lost) == sorted([real, twin])
    tune(longer, resume=True)
    after = {trial.number: trial for trial in longer.trials}
    assert set(before) - set(after) == {real, twin}
    assert max(after) > max(before)
    assert all(np.isfinite(trial.objective) for trial in after.values())
    assert longer.best is not None


def test_the_last_run_that_was_damaged_is_asked_for_again(tmp_path: Path) -> None:
    study = write_study(tmp_path, seed=2, budget="is1_runs = 4")
    tune(study, resume=False)
    before = study.trials
    path = study.location / "trials" / f"{before[-1].number:06d}.h5"
    path.write_bytes(path.read_bytes()[:5000])
    repair_folder(study.location)
    tune(study, resume=True)
    again = study.trials
    assert [trial.number for trial in again] == [trial.number for trial in before]
    assert again[-1].gains == before[-1].gains
    assert again[-1].objective == pytest.approx(before[-1].objective)
