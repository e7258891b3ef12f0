"""The log says that a study ended, also where nothing can be recommended, until it goes on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gmfbo.cli import main
from gmfbo.recordings.store.study_folder import StudyStore
from gmfbo.reports.study.follower import StudyFollower
from gmfbo.reports.study.review import StudyReview
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.tuning.history.standing import standing_events
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.told.undo import take_back
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study

ALL = frozenset(range(1, 100))
PLANTS = {
    "settles": AnalyticAxis(),
    "never settles": AnalyticAxis(inertia=50.0),
    "always fails": AnalyticAxis(failing=ALL),
}
AT_A_BENCH = """
method = "random"
[is1]
ask_tell = true
[is2]
twin = "{axis}"
[reference]
step = 0.01
horizon = 0.2
[objective]
normalise = 2
[budget]
initial_is1 = 1
initial_is2 = 2
is1_runs = 1
"""
BUDGET = "initial_is1 = 2\niterations = {}"


def tuner_of(study: Study, plant: str) -> Tuner:
    return Tuner(study, is1=replace(PLANTS[plant], seen=[]), is2=AnalyticAxis())


def ended_study(folder: Path, plant: str) -> Study:
    study = write_study(folder, budget=BUDGET.format(1))
    with tuner_of(study, plant) as tuner:
        tuner.run()
    return study


def ended(study: Study) -> bool:
    return StudyReview.read(study.location).ended


def logged(study: Study) -> list[str]:
    with StudyStore.open(study.location) as store:
        return [event["event"] for event in store.events()]


@pytest.mark.parametrize("plant", PLANTS)
def test_a_study_of_any_outcome_has_an_end_and_watching_it_ends(
    tmp_path: Path, plant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    study = ended_study(tmp_path, plant)
    assert ended(study)
    follower = StudyFollower(study.location)
    follower.news()
    assert follower.state == "ended"
    assert ("recommendation" in logged(study)) == (plant == "settles")
    assert main(["watch", str(study.location)]) == 0
    assert "real run 3: " in capsys.readouterr().out


@pytest.mark.parametrize("plant", PLANTS)
def test_a_study_that_goes_on_with_more_budget_has_not_ended(tmp_path: Path, plant: str) -> None:
    ended_study(tmp_path, plant)
    more = write_study(tmp_path, budget=BUDGET.format(2))
    with tuner_of(more, plant) as tuner:
        request = tuner.ask()
        assert request is not None
        assert not ended(more)
        tuner.tell(request, PLANTS["settles"].run(request.gains, tuner.experiment.reference))
        assert not ended(more)
        assert tuner.ask() is None
        tuner.result()
    assert ended(more)


@pytest.mark.parametrize("plant", PLANTS)
def test_a_study_whose_last_run_is_taken_back_has_not_ended(tmp_path: Path, plant: str) -> None:
    study = ended_study(tmp_path, plant)
    take_back(study)
    assert not ended(study)
    with StudyStore.open(study.location) as store:
        assert "end" not in [one["event"] for one in standing_events(store.events(), set())]


def test_going_on_without_more_budget_leaves_it_ended(tmp_path: Path) -> None:
    study = ended_study(tmp_path, "never settles")
    with tuner_of(study, "never settles") as tuner:
        assert ended(study)
        tuner.run()
    assert ended(study)


def test_a_result_taken_between_runs_logs_no_end(tmp_path: Path) -> None:
    study = write_study(tmp_path, budget=BUDGET.format(1))
    with tuner_of(study, "never settles") as tuner:
        request = tuner.ask()
        assert request is not None
        tuner.result()
        tuner.tell(request, AnalyticAxis().run(request.gains, tuner.experiment.reference))
        tuner.result()
    assert "end" not in logged(study)


def test_a_study_of_a_former_version_ended_with_its_recommendation(tmp_path: Path) -> None:
    study = ended_study(tmp_path, "settles")
    review = StudyReview.read(study.location)
    former = tuple(event for event in review.events if event["event"] != "end")
    assert len(former) < len(review.events)
    assert replace(review, events=former).ended


def test_a_script_that_asks_to_the_end_finds_the_study_ended(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    axis, path = (models_folder() / "linear_axis.toml").as_posix(), tmp_path / "bench.toml"
    path.write_text(AT_A_BENCH.format(axis=axis), encoding="utf-8")
    assert main(["ask", str(path), "--json", "--random-start"]) == 0
    assert main(["tell", str(path), "--failed", "lost the encoder"]) == 0
    capsys.readouterr()
    assert main(["ask", str(path), "--json"]) == 0
    assert capsys.readouterr().out == "null\n"
    assert ended(Study.read(path))
