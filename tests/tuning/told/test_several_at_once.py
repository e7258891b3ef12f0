"""Several runs asked for at once, told in any order, and the last one taken back."""

from __future__ import annotations

from pathlib import Path

import pytest

from gmfbo.errors import InputError
from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.review import StudyReview
from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.query.request import TrialRequest
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.told.undo import take_back
from gmfbo.tuning.tuner import Tuner
from tests.tuning.analytic_axis import AnalyticAxis, write_study
from tests.tuning.methods.quick_methods import QUICK

BUDGET = "is1_runs = 6\ninitial_is1 = 2\ninitial_is2 = 10"
QUERIES = "iterations = 6\ninitial_is1 = 2\ninitial_is2 = 10"
PLANT = AnalyticAxis()


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return write_study(tmp_path, method="random", budget=BUDGET)


def tuner_of(study: Study) -> Tuner:
    return Tuner(study, is1=PLANT, is2=AnalyticAxis(inertia=0.2, friction=0.4))


def tell(tuner: Tuner, request: TrialRequest | int, gains: TrialRequest) -> None:
    tuner.tell(request, PLANT.run(gains.gains, tuner.experiment.reference))


def test_as_many_runs_as_wanted_are_asked_for_and_asked_again(study: Study) -> None:
    with tuner_of(study) as tuner:
        three = tuner.ask(parallel=3)
        assert [request.number for request in three] == [11, 12, 13]
        assert len({tuple(request.gains.values()) for request in three}) == 3
        assert tuner.ask(parallel=3) == three
    with tuner_of(study) as tuner:
        assert list(tuner.waiting) == three
        tell(tuner, 12, three[1])
        filled = tuner.ask(parallel=3)
        assert filled[:2] == [three[0], three[2]]
        assert filled[2].number == 14
        assert len(tuner.ask(parallel=9)) == 5  # the budget's six, one of them told


@pytest.mark.parametrize("name", sorted(METHODS))
def test_more_than_the_first_runs_are_asked_for_before_any_is_told(
    tmp_path: Path, name: str
) -> None:
    study = write_study(tmp_path, method=name, budget=QUERIES)
    twin = AnalyticAxis(inertia=0.2, friction=0.4)
    with Tuner(study, is1=PLANT, is2=twin, method=QUICK[name]) as tuner:
        first = tuner.ask(parallel=2)
        five = tuner.ask(parallel=5)
        assert five[:2] == first
        assert len({tuple(request.gains.values()) for request in five}) == 5
        assert all(request.note == "" for request in five)
        tuner.gains.check_fixed(five[-1].gains)  # lies in the box
    with Tuner(study, is1=PLANT, is2=twin, method=QUICK[name]) as tuner:
        assert tuner.ask(parallel=5) == five
        tell(tuner, five[4].number, five[4])
        assert tuner.ask() == five[0]
        assert tuner.ask(parallel=5)[:4] == five[:4]  # one more by the method, or runs of the twin


def test_runs_told_in_another_order_are_kept_in_that_order(study: Study) -> None:
    with tuner_of(study) as tuner:
        three = tuner.ask(parallel=3)
        for place in (2, 0, 1):
            tell(tuner, three[place], three[place])
        told = [trial.number for trial in tuner.history.of("IS1")]
        following = tuner.ask()
    assert told == [13, 11, 12]
    with tuner_of(study) as tuner:
        assert [trial.number for trial in tuner.history.of("IS1")] == told
        assert tuner.ask() == following


def test_a_recording_that_states_its_gains_finds_its_run(study: Study) -> None:
    with tuner_of(study) as tuner:
        three = tuner.ask(parallel=3)
        run = PLANT.run(three[1].gains, tuner.experiment.reference)
        assert tuner.tell(None, run).number == three[1].number
        bare = type(run)(time=run.time, signals=run.signals)
        with pytest.raises(InputError, match="trials 11, 13 are waited for"):
            tuner.tell(None, bare)


def test_the_last_told_run_is_taken_back_and_asked_for_again(study: Study) -> None:
    with tuner_of(study) as tuner:
        first, second = tuner.ask(parallel=2)
        tell(tuner, first, first)
        tell(tuner, second, second)
        tuner.ask()  # is withdrawn: it followed from the run that is taken back
    back = take_back(study)
    assert back.trial.number == second.number
    assert second.number in {trial.number for trial in study.trials}
    assert study.taken_back == {second.number}
    with tuner_of(study) as tuner:
        assert [trial.number for trial in tuner.history.of("IS1")] == [first.number]
        (again,) = tuner.waiting
        assert (again.number, again.gains) == (back.again, second.gains)
        tell(tuner, again, again)
    assert study.best is not None
    assert study.best.number != second.number
    page = study_page(StudyReview.read(study.location))
    assert f"<s>run {second.number}:" in page


def test_taking_back_goes_on_to_the_run_before_and_ends_there(study: Study) -> None:
    with tuner_of(study) as tuner:
        first, second = tuner.ask(parallel=2)
        tell(tuner, first, first)
        tell(tuner, second, second)
    assert take_back(study).trial.number == second.number
    assert take_back(study).trial.number == first.number
    with pytest.raises(InputError, match="no told run is left"):
        take_back(study)
    with tuner_of(study) as tuner:
        assert tuner.history.of("IS1") == []


def test_of_several_runs_one_failed_for_another_reason_than_its_gains(study: Study) -> None:
    with tuner_of(study) as tuner:
        three = tuner.ask(parallel=3)
        with pytest.raises(InputError, match=r"trials 11, 12, 13 are waited for.*--trial"):
            tuner.not_the_gains(None, "door was open")
        assert tuner.not_the_gains(12, "door was open") == three[1]
        assert tuner.ask(parallel=3) == three
        assert not tuner.history.of("IS1")
