"""What every method promises to the loop; a new method is tested by being listed."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.query.method import CorrectionOptions, Method
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study
from tests.tuning.methods.quick_methods import QUICK, SURVEY

BUDGET = "iterations = 2\ninitial_is1 = 2\nis3_per_run = 1"
Runs = list[tuple[str, dict[str, float], float]]


def tuner_of(study: Study, method: Method) -> Tuner:
    return Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2), method=method)


def runs_of(study: Study) -> Runs:
    return [(t.source, dict(t.gains), t.objective) for t in study.trials]


@dataclass(frozen=True)
class Played:
    """A study of one method, run through."""

    method: Method
    study: Study
    folder: Path


@pytest.fixture(scope="module", params=sorted(METHODS))
def played(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Played:
    folder = tmp_path_factory.mktemp(request.param)
    method = QUICK[request.param]
    study = write_study(folder / "whole", method=request.param, seed=4, budget=BUDGET)
    with tuner_of(study, method) as tuner:
        tuner.run()
    return Played(method, study, folder)


def test_all_gains_lie_in_the_box_and_all_costs_are_finite(played: Played) -> None:
    for _, gains, cost in runs_of(played.study):
        assert 30.0 <= gains["ctl.Kp"] <= 200.0
        assert 2.0 <= gains["ctl.Kd"] <= 10.0
        assert np.isfinite(cost)


def test_it_asks_beyond_the_initial_runs_and_ends(played: Played) -> None:
    queries = [t for t in played.study.trials if t.source == "IS1"][2:]
    twin = [t for t in played.study.trials if t.source == "IS2" and t.parent is None]
    survey = played.method.correction.survey if played.method.correction else 0
    asked = len(queries) + len(twin) - 10 - survey
    assert asked == (1 if played.method.name == "twin_once" else 2)


def test_no_query_is_a_repeat(played: Played) -> None:
    points = [tuple(t.gains.values()) for t in played.study.trials if t.source == "IS1"]
    assert len(set(points)) == len(points)


def test_it_recommends_finite_gains_of_the_box(played: Played) -> None:
    recommended = played.study.recommendation
    assert recommended is not None
    assert 30.0 <= recommended.gains["ctl.Kp"] <= 200.0
    assert np.isfinite(recommended.mean)
    assert recommended.std >= 0.0


def test_a_study_reopened_after_each_run_asks_for_the_same(played: Played) -> None:
    name = played.method.name
    study = write_study(played.folder / "reopened", method=name, seed=4, budget=BUDGET)
    axis = AnalyticAxis()
    for _ in itertools.count():
        with tuner_of(study, played.method) as tuner:
            request = tuner.ask()
        if request is None:
            break
        with tuner_of(study, played.method) as tuner:
            again = tuner.ask()
            assert again is not None
            assert again.gains == request.gains
            tuner.tell(again, axis.run(again.gains, tuner.experiment.reference))
    assert runs_of(study) == runs_of(played.study)


def test_options_of_a_survey_alone_make_no_corrected_runs(tmp_path: Path) -> None:
    study = write_study(tmp_path, method="twin_once", budget=BUDGET)
    with tuner_of(study, QUICK["twin_once"]) as tuner:
        tuner.run()
    assert CorrectionOptions().around_real
    assert all(t.parent is None for t in study.trials)
    assert sum(t.source == "IS2" for t in study.trials) == 10 + SURVEY


def test_twin_once_runs_the_best_of_the_twin(tmp_path: Path) -> None:
    study = write_study(tmp_path, method="twin_once", budget=BUDGET)
    with tuner_of(study, QUICK["twin_once"]) as tuner:
        result = tuner.run()
    twin = min((t for t in study.trials if t.source == "IS2"), key=lambda t: t.objective)
    last = [t for t in study.trials if t.source == "IS1"][-1]
    assert last.gains == pytest.approx(twin.gains)
    assert result.is1_runs == 3
