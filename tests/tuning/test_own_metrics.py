"""A user's own metrics decide, limit, and fail as a run fails."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from gmfbo.cli.tuning.objective_text import objective_table
from gmfbo.cli.tuning.study_result import metric_lines
from gmfbo.errors import InputError, OwnMetricsError, StudyFileError
from gmfbo.objective.own_metrics import OwnMetrics
from gmfbo.recordings.recording import Recording
from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.page_json import study_content
from gmfbo.reports.study.review import StudyReview
from gmfbo.tuning.tuner import Tuner
from tests.tuning.linear_study import linear_study

SOURCE = """
import numpy as np

def effort(run):
    voltage = run.signal("drive_voltage")
    return {"effort": float(np.sqrt(np.mean(voltage**2))), "peak": float(np.abs(voltage).max())}

def lag(run):
    error = run.signal("reference") - run.signal("position")
    return float(np.mean(np.abs(error)))

def broken(run):
    return {"effort": float("nan")}

def moody(run):
    if run.parameters["kp"] > 150.0:
        raise ValueError("no")
    return {"effort": 1.0 + run.parameters["kp"]}
"""

EFFORT = '[objective]\nmetrics = "mine.py:{name}"\nweights = {{ {weights} }}\n'


def section(folder: Path, name: str, weights: str) -> str:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "mine.py").write_text(SOURCE, encoding="utf-8")
    return EFFORT.format(name=name, weights=weights)


def test_an_own_metric_of_any_recorded_signal_decides(tmp_path: Path) -> None:
    study = linear_study(tmp_path, section(tmp_path, "effort", "effort = 1.0"), iterations=3)
    with Tuner(study) as tuner:
        tuner.run()
    real = [trial for trial in study.trials if trial.source == "IS1"]
    for trial in real:
        voltage = trial.recording.signal("drive_voltage")
        assert trial.metrics["effort"] == pytest.approx(np.sqrt(np.mean(voltage**2)))
    assert study.best is not None
    assert study.best.metrics["effort"] == min(trial.metrics["effort"] for trial in real)
    assert study.objective is not None
    for trial in real:
        assert trial.objective == pytest.approx(float(study.objective.value(trial.metrics)))


def test_negative_control_without_it_another_run_is_best(tmp_path: Path) -> None:
    quick = linear_study(tmp_path, section(tmp_path, "effort", "rise_time = 1.0"), iterations=3)
    with Tuner(quick) as tuner:
        tuner.run()
    real = [trial for trial in quick.trials if trial.source == "IS1"]
    assert quick.best is not None
    assert quick.best.metrics["effort"] > min(trial.metrics["effort"] for trial in real)


def test_a_limit_on_an_own_metric_is_kept(tmp_path: Path) -> None:
    text = section(tmp_path, "effort", "rise_time = 1.0") + "[constraints]\npeak = 5.0\n"
    study = linear_study(tmp_path, text, iterations=5)
    with Tuner(study) as tuner:
        tuner.run()
    assert study.best is not None
    assert study.best.metrics["peak"] <= 5.0


def test_the_stated_unit_of_an_own_metric_is_shown_in_terminal_and_report(tmp_path: Path) -> None:
    weights = section(tmp_path, "effort", "rise_time = 1.0, effort = 1.0, peak = 0.0")
    study = linear_study(tmp_path, weights + 'units = { effort = "V" }\n', iterations=0)
    with Tuner(study) as tuner:
        tuner.run()
    assert study.best is not None
    lines = metric_lines(study, study.best)
    shown = {line.split()[0]: line for line in lines}
    assert re.search(r"^effort +[\d.]+ V$", shown["effort"])
    assert re.search(r"^peak +[\d.]+$", shown["peak"])  # control: none was stated
    assert study.objective is not None
    (told,) = [
        line
        for line in objective_table(study.objective, study.best.metrics, study.metric_words, "")
        if "effort" in line
    ]
    assert re.search(r"mean [\d.]+ V, spread [\d.]+ V", told)
    review = StudyReview.read(study.location)
    assert study_content(review)["metrics"]["effort"] == "V"
    page = study_page(review)
    assert page.count("effort [V]") >= 2  # first screen and table of the runs
    assert "peak [" not in page


def test_a_metric_of_the_scored_signal_is_foreseen_by_the_corrected_twin(tmp_path: Path) -> None:
    study = linear_study(tmp_path, section(tmp_path, "lag", "lag = 1.0"), iterations=1)
    with Tuner(study) as tuner:
        tuner.run()
        experiment = tuner.experiment
        trial = study.trials[-1]
        foreseen = experiment.metrics_of(trial.recording.time, trial.recording.signal("position"))
    assert foreseen["lag"] == pytest.approx(trial.metrics["lag"])
    other = linear_study(tmp_path / "b", section(tmp_path / "b", "effort", "effort = 1.0"))
    with Tuner(other) as tuner:
        unknown = tuner.experiment.metrics_of(
            trial.recording.time, trial.recording.signal("position")
        )
    assert np.isnan(unknown["effort"])
    assert study.objective is not None
    assert np.isfinite(study.objective.value({**unknown, "lag": np.nan}))


def test_a_run_that_the_function_refuses_fails_and_ends_nothing(tmp_path: Path) -> None:
    text = section(tmp_path, "moody", "effort = 1.0")
    study = linear_study(tmp_path, text, method="random", iterations=4)
    with Tuner(study) as tuner:
        result = tuner.run()
    assert result.is1_runs == 6
    for trial in study.trials:
        assert (trial.status == "failed") == (trial.gains["kp"] > 150.0)
        assert np.isfinite(trial.objective)
        assert all(np.isfinite(value) for value in trial.metrics.values())


def test_another_function_is_refused_once_the_study_was_begun(tmp_path: Path) -> None:
    study = linear_study(tmp_path, section(tmp_path, "lag", "lag = 1.0"), iterations=0)
    with Tuner(study) as tuner:
        tuner.run()
    (tmp_path / "mine.py").write_text(SOURCE + "\n", encoding="utf-8")
    with pytest.raises(StudyFileError, match=r"\[objective\] metrics has changed since"):
        Tuner(study)


def test_what_a_function_must_be_is_said(tmp_path: Path) -> None:
    section(tmp_path, "lag", "lag = 1.0")
    (tmp_path / "bad.py").write_text("import nothing_of_that_name", encoding="utf-8")
    with pytest.raises(InputError, match=r'expected "FILE\.py:FUNCTION", got \'mine\''):
        OwnMetrics.load("mine", tmp_path)
    with pytest.raises(InputError, match="no file"):
        OwnMetrics.load("yours.py:lag", tmp_path)
    with pytest.raises(InputError, match=r"no function 'lagg'; did you mean 'lag'"):
        OwnMetrics.load("mine.py:lagg", tmp_path)
    with pytest.raises(InputError, match="cannot be imported: ModuleNotFoundError"):
        OwnMetrics.load("bad.py:f", tmp_path)
    run = Recording(time=np.arange(3.0), signals={})
    with pytest.raises(OwnMetricsError, match="expected a finite number for 'effort', got nan"):
        OwnMetrics.load("mine.py:broken", tmp_path).of(run)
    lacking = OwnMetrics("m.py:f", lambda _: {"a": 1.0}, required=frozenset({"b"}))
    with pytest.raises(OwnMetricsError, match="expected 'b' in what it returns, got a"):
        lacking.of(run)
    with pytest.raises(StudyFileError, match=r"no metric 'effort'.*one of your own needs"):
        linear_study(tmp_path, "[objective]\nweights = { effort = 1.0 }\n")
