"""A study begins with a table of gains and results of earlier runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.cli.tuning.study_result import metric_lines
from gmfbo.errors import InputError, StudyFileError
from gmfbo.recordings.store.trial import Trial
from gmfbo.reports.figures.trajectory_figure import trajectories
from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.review import StudyReview
from gmfbo.retuning.real_runs import usable_trials
from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.methods.twin_rows import axis_runs, sample_times
from gmfbo.tuning.query.request import TuningResult
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study
from tests.tuning.linear_study import linear_study
from tests.tuning.methods.quick_methods import QUICK

COUNTED = "overshoot", "transient_time", "rise_time", "settling_time"
HEAD = "ctl.Kp,ctl.Kd,overshoot [%],transient_time [s],rise_time [ms],settling_time [s],who"
TABLE = f"""# bench 3, last spring
{HEAD}
60,6,12.5,0.21,35,0.22,Ada
90,7,9.5,0.17,28,0.18,Ada
120,8,8.0,0.14,24,0.15,Bo
20,8,8.0,0.14,24,0.15,outside the box
130,8,8.0,0.14,,0.15,no rise time
140,2.5,60,0.5,20,0.5,never settled
,8,8.0,0.14,24,0.15,no gain
"""
TAKEN = [(60.0, 6.0), (90.0, 7.0), (120.0, 8.0)]


def study_with(
    folder: Path, table: str = TABLE, method: str = "bo_ei", budget: str = "is1_runs = 2"
) -> Study:
    """A study beside a table, which it names."""
    study = write_study(folder, method=method, budget=budget)
    (folder / "results.csv").write_text(table, encoding="utf-8")
    path = folder / "axis.toml"
    text = path.read_text(encoding="utf-8").replace("[is1]", 'earlier = "results.csv"\n[is1]', 1)
    path.write_text(text, encoding="utf-8")
    return Study.read(study.origin / "axis.toml")


def tuner_of(study: Study) -> Tuner:
    method = QUICK[study.file.method]
    return Tuner(study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2), method=method)


def tuned(study: Study) -> TuningResult:
    with tuner_of(study) as tuner:
        return tuner.run()


def real(study: Study) -> list[Trial]:
    return [trial for trial in study.trials if trial.source == "IS1"]


def test_rows_come_first_and_what_is_not_taken_over_is_listed(tmp_path: Path) -> None:
    study = study_with(tmp_path)
    result = tuned(study)
    assert (result.earlier, result.left_out, result.is1_runs) == (3, 4, 2)
    assert [tuple(trial.gains.values()) for trial in real(study)][:3] == TAKEN
    assert set(result.why_left_out) == {
        "1: ctl.Kp lies outside [30, 200]",
        "1: rise time is missing",
        "1: settling time is as long as the horizon: the run did not settle",
        "1: ctl.Kp is not said",
    }
    first = real(study)[0]
    assert first.metrics["rise_time"] == pytest.approx(0.035)  # ms in the header
    assert first.metrics["overshoot"] == 12.5
    assert study.objective is not None
    assert first.objective == pytest.approx(float(study.objective.value(first.metrics)))
    assert first.bare
    assert not real(study)[-1].bare


def test_a_decimal_comma_and_a_percentage_as_a_share_are_understood(tmp_path: Path) -> None:
    head = HEAD.replace("overshoot [%]", "overshoot [1]").replace(",", ";")
    table = f"{head}\n60;6,5;0,125;0,21;35;0,22;Ada\n"
    study = study_with(tmp_path, table)
    assert tuned(study).earlier == 1
    assert real(study)[0].gains["ctl.Kd"] == 6.5
    assert real(study)[0].metrics["overshoot"] == pytest.approx(12.5)


def test_gains_are_converted_to_the_unit_of_their_parameter(tmp_path: Path) -> None:
    sections = "[gains]\nkp = [40, 320]\nkv = [80, 240]\n"
    study = linear_study(tmp_path, sections, iterations=0)
    with Tuner(study) as tuner:
        units = tuner._sources.units_of(tuner.gains)
    assert units["kp"] == "s-1"
    path = tmp_path / "linear.toml"
    text = path.read_text(encoding="utf-8").replace("[is1]", 'earlier = "r.csv"\n[is1]', 1)
    path.write_text(text.replace('name = "linear"', 'name = "again"'), encoding="utf-8")
    rows = "kp [1/min],kv,overshoot,transient_time,rise_time,settling_time\n3600,120,3,.1,.02,.1\n"
    (tmp_path / "r.csv").write_text(rows, encoding="utf-8")
    with Tuner(Study.read(path)) as tuner:
        tuner.run()
        assert tuner.history.of("IS1")[0].gains["kp"] == pytest.approx(60.0)
    (tmp_path / "r.csv").write_text(rows.replace("1/min", "mm"), encoding="utf-8")
    path.write_text(text.replace('name = "linear"', 'name = "third"'), encoding="utf-8")
    with pytest.raises(StudyFileError, match=r"'kp' is in 'mm', and the study has 's-1' for it"):
        Tuner(Study.read(path))


@pytest.mark.parametrize("name", sorted(METHODS))
def test_every_method_goes_on_from_rows(tmp_path: Path, name: str) -> None:
    study = study_with(tmp_path, method=name, budget="iterations = 2\nis3_per_run = 1")
    result = tuned(study)
    assert result.earlier == 3
    assert result.recommendation is not None
    assert all(np.isfinite(trial.objective) for trial in study.trials)


def test_the_corrected_twin_learns_costs_from_rows_but_no_trajectories(tmp_path: Path) -> None:
    with tuner_of(study_with(tmp_path, method="gmfbo", budget="is1_runs = 1")) as tuner:
        tuner.run()
        state, history = tuner.history.state({}), tuner.history
        runs, _ = axis_runs(state, sample_times(state))
        assert runs.paired.tolist() == [False, False, False, True]
        assert runs.values == pytest.approx([trial.objective for trial in history.of("IS1")])
        assert [trial.number for trial in usable_trials(history)] == [history.of("IS1")[-1].number]


def test_stopped_while_rows_are_taken_over_goes_on_as_if_not(tmp_path: Path) -> None:
    whole = study_with(tmp_path / "whole")
    tuned(whole)
    expected = [(t.number, dict(t.gains), t.objective) for t in whole.trials]
    study = study_with(tmp_path / "stopped")

    def watch(step: object) -> None:
        if getattr(step, "trial", 0) == 12:
            raise KeyboardInterrupt

    with tuner_of(study) as tuner, pytest.raises(KeyboardInterrupt):
        tuner.run(watch)
    tuned(study)
    assert [(t.number, dict(t.gains), t.objective) for t in study.trials] == expected


def test_a_row_is_no_proof_that_a_run_stayed_inside(tmp_path: Path) -> None:
    safety = "is1_runs = 2\n[safety]\nposition = [-0.1, 1.4]\n"
    with tuner_of(study_with(tmp_path, budget=safety)) as tuner:
        tuner.ask()
        assert len(tuner.history.of("IS1")) == 3
        assert len(tuner.history.keep_out().safe) == 0


def test_page_terminal_and_figure_show_rows_and_runs(tmp_path: Path) -> None:
    table = f"{HEAD}\n60,6,0.01,0.01,1,0.01,the best of all\n"
    study = study_with(tmp_path, table)
    tuned(study)
    review = StudyReview.read(study.location)
    assert review.best is not None
    assert review.best.bare
    assert "settling time" in study_page(review)
    told = {line.split("  ")[0]: line for line in metric_lines(study, review.best)}
    assert told["rise time"].endswith("0.0010 s")
    assert trajectories(review) is not None  # of the best run with signals
    with pytest.raises(InputError, match=r"run 11 is a row of a table, without signals"):
        trajectories(review, review.best.number)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (TABLE.replace("rise_time", "risetime"), "no column 'rise_time'; did you mean 'risetime'"),
        (TABLE.replace("ctl.Kd", "damping"), r"no column 'ctl\.Kd'"),
        (TABLE.replace("[ms]", "[furlong]"), "'rise_time' is in 'furlong', which is no known"),
        (TABLE.replace("[ms]", "[mm]"), "'rise_time' is in 'mm', and the study has 's' for it"),
        (f"{HEAD}\n20,8,8,0.14,24,0.15,x\n", r"1 were made, none of them is \(1: ctl\.Kp lies"),
        ("", "expected a header"),
    ],
)
def test_a_table_that_cannot_be_read_is_refused_in_one_line_and_nothing_is_begun(
    tmp_path: Path, table: str, message: str
) -> None:
    study = study_with(tmp_path, table)
    with pytest.raises(StudyFileError, match=message) as refused:
        tuned(study)
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith("earlier = 'results.csv'")
    assert not study.begun


def test_a_table_beside_several_references_is_refused(tmp_path: Path) -> None:
    study = study_with(tmp_path)
    path = study.origin / "axis.toml"
    text = path.read_text(encoding="utf-8")
    begin, end = text.index("[reference]"), text.index("[budget]")
    part = text[begin:end].replace("[reference]", "[[reference]]")
    path.write_text(text[:begin] + part + part + text[end:], encoding="utf-8")
    with pytest.raises(StudyFileError, match="this study plays 2 references a query; name an"):
        tuned(Study.read(path))


def test_a_limited_metric_needs_a_column_and_rows_are_held_to_the_limit(tmp_path: Path) -> None:
    limited = "is1_runs = 1\n[constraints]\novershoot = 9.0\nrms_error = 1.0\n"
    with pytest.raises(StudyFileError, match="no column 'rms_error'"):
        tuned(study_with(tmp_path / "a", budget=limited))
    study = study_with(tmp_path / "b", budget=limited.replace("rms_error = 1.0\n", ""))
    tuned(study)
    assert study.best is not None
    assert study.best.metrics["overshoot"] <= 9.0
