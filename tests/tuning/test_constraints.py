"""Limits on metrics in a study of the linear axis, whose quickest gains overshoot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.objective.limits import Limits
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.history.incumbent import best_run
from gmfbo.tuning.methods.beliefs import search_of
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.linear_study import linear_study
from tests.tuning.methods.quick_methods import QUICK

QUICKEST = "[objective]\nweights = { rise_time = 1.0 }\n"
LIMIT = 20.0  # [%]
LIMITED = QUICKEST + f"[constraints]\novershoot = {LIMIT}\n"


def run(study: Study) -> list[Trial]:
    with Tuner(study, method=QUICK[study.file.method]) as tuner:
        tuner.run()
    return real(study)


@pytest.fixture(scope="module")
def limited(tmp_path_factory: pytest.TempPathFactory) -> Study:
    study = linear_study(tmp_path_factory.mktemp("limited"), LIMITED, iterations=6)
    run(study)
    return study


@pytest.fixture(scope="module")
def unlimited(tmp_path_factory: pytest.TempPathFactory) -> Study:
    study = linear_study(tmp_path_factory.mktemp("unlimited"), QUICKEST, iterations=6)
    run(study)
    return study


def real(study: Study) -> list[Trial]:
    return [trial for trial in study.trials if trial.source == "IS1"]


def overshoots(trials: list[Trial]) -> np.ndarray:
    return np.array([trial.metrics["overshoot"] for trial in trials])


def test_the_best_gains_meet_the_limit_and_are_still_quick(limited: Study) -> None:
    best = limited.best
    assert best is not None
    assert best.metrics["overshoot"] <= LIMIT
    feasible = [t.objective for t in real(limited) if t.metrics["overshoot"] <= LIMIT]
    assert best.objective == min(feasible)


def test_negative_control_without_the_limit_the_best_gains_break_it(unlimited: Study) -> None:
    assert unlimited.best is not None
    assert unlimited.best.metrics["overshoot"] > LIMIT


def test_proposals_meet_the_limit_more_often_than_without_it(
    limited: Study, unlimited: Study
) -> None:
    with_limit, without = (overshoots(real(study)[2:]) for study in (limited, unlimited))
    assert np.mean(with_limit <= LIMIT) >= np.mean(without <= LIMIT) + 0.3


def test_the_corrected_twin_foresees_the_limit(tmp_path: Path) -> None:
    study = linear_study(tmp_path, LIMITED, method="gmfbo", iterations=2)
    assert np.all(overshoots(run(study)[2:]) <= 1.5 * LIMIT)


def test_the_weight_is_the_probability_that_the_axis_meets_the_limit(limited: Study) -> None:
    with Tuner(limited) as tuner:
        state = tuner.history.state({})
    search = search_of(state)
    seen = state.of("IS1")
    weights = np.exp(search.log_weights(np.stack([one.point for one in seen])))
    met = np.array([one.feasible for one in seen])
    assert met.any()
    assert (~met).any()
    assert weights[met].min() > weights[~met].max()


def test_feasible_runs_come_first_whatever_they_cost(unlimited: Study) -> None:
    trials = real(unlimited)
    cheap = min(trials, key=lambda trial: trial.objective)
    tame = min(trials, key=lambda trial: trial.metrics["overshoot"])
    assert cheap.number != tame.number
    least = tame.metrics["overshoot"]
    assert best_run(trials, Limits()) is cheap
    assert best_run(trials, Limits({"overshoot": least})) is tame
    # Where no run meets the limit, the one that exceeds it least is the best there is.
    assert best_run(trials, Limits({"overshoot": least - 1.0})) is tame
