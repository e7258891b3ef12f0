"""What the page on studies tells a user to write is what the package takes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from gmfbo.objective.own_metrics import OwnMetrics
from gmfbo.recordings.recording import Recording
from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study_file.study_file import parse_study
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study

PAGE = Path(__file__).resolve().parents[1] / "notebooks/docs/studies.md"
TEXT = PAGE.read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", TEXT, re.DOTALL)


def test_the_study_file_on_the_page_says_what_the_page_says_it_does() -> None:
    (text,) = [block for block in blocks("toml") if "[is2]" in block]
    study = parse_study(text, label="page", default_name="page")
    assert study.gains["ctl.Kp"].scale == "log"
    assert study.gains["ctl.Kd"].integer
    assert [part.weight for part in study.references] == [2.0, 1.0]
    assert study.constraints == {"overshoot": 5.0}
    assert study.safety.envelope.ranges["torque_command"] == (-150.0, 150.0)
    assert study.own_metrics == {"effort"}
    assert study.objective.units == {"effort": "N.m"}


def test_the_metric_on_the_page_is_a_root_mean_square(tmp_path: Path) -> None:
    (source,) = [block for block in blocks("python") if "# mine.py" in block]
    (tmp_path / "mine.py").write_text(source, encoding="utf-8")
    own = OwnMetrics.load("mine.py:effort", tmp_path, frozenset({"effort"}))
    run = Recording(np.array([0.0, 1.0]), {"torque_command": np.array([3.0, 4.0])})
    assert own.of(run)["effort"] == pytest.approx(12.5**0.5)


def test_the_method_on_the_page_tunes(tmp_path: Path) -> None:
    (source,) = [block for block in blocks("python") if "class Corner" in block]
    names: dict[str, type] = {}
    exec(source, names)
    study = write_study(tmp_path, budget="is1_runs = 4")
    with Tuner(
        study, is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2), method=names["Corner"]()
    ) as tuner:
        tuner.run()
    asked = [trial.gains["ctl.Kp"] for trial in study.trials if trial.source == "IS1"]
    assert asked[2:] == pytest.approx([166.0, 149.0])


def test_methods_printed_on_the_page_are_those_there_are() -> None:
    for name, method in METHODS.items():
        line = f"{name:<16} {method.summary}"
        assert line in TEXT or not re.search(rf"^{name} ", TEXT, re.MULTILINE), name
    assert f"{'bo_ei':<16} {METHODS['bo_ei'].summary}" in TEXT


def test_nothing_on_the_page_waits_to_be_filled_in() -> None:
    assert not re.findall(r"^@[A-Z]+@$", TEXT, re.MULTILINE)


def test_the_table_on_the_page_is_taken_over(tmp_path: Path) -> None:
    (table,) = [block.lstrip("\n") for block in TEXT.split("```") if ";who" in block]
    study = write_study(tmp_path, budget="is1_runs = 1")
    (tmp_path / "results.csv").write_text(table, encoding="utf-8")
    path = tmp_path / "axis.toml"
    text = path.read_text(encoding="utf-8").replace("[is1]", 'earlier = "results.csv"\n[is1]', 1)
    path.write_text(text, encoding="utf-8")
    with Tuner(Study.read(path), is1=AnalyticAxis(), is2=AnalyticAxis(inertia=0.2)) as tuner:
        assert tuner.run().earlier == 2
    first = next(trial for trial in study.trials if trial.source == "IS1")
    assert first.gains == pytest.approx({"ctl.Kp": 60.0, "ctl.Kd": 6.5})
    assert first.metrics["rise_time"] == pytest.approx(0.035)
