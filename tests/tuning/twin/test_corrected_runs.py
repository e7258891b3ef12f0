"""What follows a real run: the twin beside it, and corrected runs around it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study

WRONG = AnalyticAxis(inertia=0.2, friction=0.4)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    study = write_study(
        tmp_path_factory.mktemp("corrected"), method="gmfbo_paper", budget="iterations = 0"
    )
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2, friction=0.4)) as tuner:
        tuner.run()
    return study


def of(study: Study, source: str) -> list[Trial]:
    return [trial for trial in study.trials if trial.source == source]


def position(gains: Mapping[str, float], axis: AnalyticAxis, like: Recording) -> np.ndarray:
    reference = np.where(like.time >= 0.05 - 1e-9, 1.0, 0.0)
    run = axis.run(gains, Recording(time=like.time, signals={"reference": reference}))
    return run.signal("position")


def test_each_real_run_is_followed_by_the_twin_and_four_corrected_runs(study: Study) -> None:
    order = [(trial.source, trial.parent) for trial in study.trials[10:]]
    expected = []
    for number in (11, 17):
        expected += [("IS1", None), ("IS2", number)] + [("IS3", number)] * 4
    assert order == expected


def test_the_twin_runs_at_the_gains_of_the_real_run(study: Study) -> None:
    pairs = [trial for trial in of(study, "IS2") if trial.parent is not None]
    assert [dict(t.gains) for t in pairs] == [dict(t.gains) for t in of(study, "IS1")]


def test_corrected_runs_keep_what_the_twin_said_and_how_sure_the_correction_is(
    study: Study,
) -> None:
    for trial in of(study, "IS3"):
        twin = position(trial.gains, WRONG, trial.recording)
        np.testing.assert_array_equal(trial.uncorrected["position"], twin)
        spread = trial.std["position"]
        sigma_c = np.sqrt(np.mean(spread**2))
        assert trial.sigma_c == pytest.approx(sigma_c)
        assert trial.accepted is bool(sigma_c <= 0.05)


def test_corrected_runs_lie_around_their_real_run(study: Study) -> None:
    centres = {trial.number: trial for trial in of(study, "IS1")}
    for trial in of(study, "IS3"):
        assert trial.parent is not None
        centre = centres[trial.parent]
        for name, width in (("ctl.Kp", 170.0), ("ctl.Kd", 8.0)):
            assert abs(trial.gains[name] - centre.gains[name]) < 5 * 0.05 * width


def test_corrected_runs_are_nearer_to_the_real_axis_than_the_twin(study: Study) -> None:
    errors = []
    for trial in of(study, "IS3"):
        real = position(trial.gains, AnalyticAxis(), trial.recording)
        errors.append(
            (
                np.sqrt(np.mean((trial.recording.signal("position") - real) ** 2)),
                np.sqrt(np.mean((trial.uncorrected["position"] - real) ** 2)),
            )
        )
    corrected, twin = np.mean(errors, axis=0)
    assert corrected < 0.6 * twin


def test_a_perfect_twin_is_left_as_it_is(tmp_path: Path) -> None:
    study = write_study(tmp_path, method="gmfbo_paper", budget="iterations = 0")
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis()) as tuner:
        tuner.run()
    for trial in of(study, "IS3"):
        real = position(trial.gains, AnalyticAxis(), trial.recording)
        np.testing.assert_allclose(trial.recording.signal("position"), real, atol=0.02)


def test_nothing_is_corrected_by_a_real_run_that_failed(tmp_path: Path) -> None:
    study = write_study(tmp_path, method="gmfbo_paper", budget="iterations = 0")
    plant = AnalyticAxis(failing=frozenset({1}))
    with Tuner(study, is1=plant, is2=AnalyticAxis(inertia=0.2)) as tuner:
        tuner.run()
    first, second = of(study, "IS1")
    assert first.status == "failed"
    assert {trial.parent for trial in of(study, "IS3")} == {second.number}


def test_a_draw_whose_simulation_fails_is_recorded_and_not_used(tmp_path: Path) -> None:
    study = write_study(tmp_path, method="gmfbo_paper", budget="iterations = 1")
    # ten initial runs, the run beside the first real one, then the second draw fails
    twin = AnalyticAxis(inertia=0.2, failing=frozenset({13}))
    with Tuner(study, is1=AnalyticAxis(), is2=twin) as tuner:
        tuner.run()
        used = {seen.number for seen in tuner.history.observations()}
    failed = [trial for trial in of(study, "IS3") if trial.status != "ok"]
    assert [trial.accepted for trial in failed] == [False]
    assert failed[0].number not in used
    first = [trial for trial in of(study, "IS3") if trial.parent == failed[0].parent]
    assert sum(trial.accepted is True for trial in first) == 4


def test_methods_without_correction_run_the_twin_initially_only(tmp_path: Path) -> None:
    study = write_study(tmp_path, method="bo_ei", budget="iterations = 1")
    with Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis()) as tuner:
        tuner.run()
    assert (len(of(study, "IS2")), len(of(study, "IS3"))) == (10, 0)
