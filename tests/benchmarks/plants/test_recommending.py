"""A method that is watched behaves as itself, and is asked once twin runs are made."""

from __future__ import annotations

from pathlib import Path

import gmfbo.retuning  # noqa: F401 - adds its methods
from gmfbo import Tuner
from gmfbo.tuning.methods import find_method
from gmfbo.tuning.twin.closer_look import LookingMethod
from gmfbo.tuning.twin.twin_version import RefiningMethod
from tests.benchmarks.plants.run import RecommendingMethod
from tests.tuning.analytic_axis import AnalyticAxis, write_study


def test_what_a_method_can_do_is_what_it_can_do_watched() -> None:
    for name, looks, refines in (("gmfbo_physics", True, True), ("bo_ei", False, False)):
        watched = RecommendingMethod(find_method(name), 2)
        assert watched.name == name
        assert isinstance(watched, LookingMethod) == looks
        assert isinstance(watched, RefiningMethod) == refines


def test_watching_changes_no_run_and_sees_each_number_of_real_runs(tmp_path: Path) -> None:
    ran = []
    for initial in (None, 2):
        study = write_study(tmp_path / str(initial), method="bo_ei", budget="is1_runs = 5")
        watched = RecommendingMethod(find_method("bo_ei"), initial)
        with Tuner(
            study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.16), method=watched
        ) as tuner:
            tuner.run()
            ran.append([trial.gains for trial in tuner.history.of("IS1")])
            tried = tuner.history.state({}).of("IS1")
        assert list(watched.points) == ([] if initial is None else [2, 3, 4])
    assert ran[0] == ran[1]
    for count, point in watched.points.items():
        assert point is not None
        assert any((one.point == point).all() for one in tried[:count])
