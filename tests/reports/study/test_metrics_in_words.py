"""The page words a metric as the terminal does: a time that was not reached is never."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from gmfbo.cli.tuning.study_result import metric_lines
from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.review import StudyReview
from gmfbo.tuning.history.remarks import remarks_on
from tests.pages.page_text import PageText
from tests.reports.study.example_studies import ExampleStudy

SLOW = {"ctl.Kp": 100.0, "ctl.Kd": 60.0}
FAST = {"ctl.Kp": 800.0, "ctl.Kd": 40.0}


@pytest.fixture
def review(tmp_path: Path) -> StudyReview:
    """First a run that does not come near the reference, then one that does."""
    made = ExampleStudy(tmp_path / "example.study")
    with made.store:
        made.trial("IS2", made.gains())
        made.real(SLOW, None)
        made.end(made.real(FAST, None).gains)
    return StudyReview.read(tmp_path / "example.study")


def cells(page: str, head: str) -> list[str]:
    """Text of all cells under a head, in all tables whose rows stack on a phone."""
    found = re.findall(rf'<td[^>]*data-head="{re.escape(head)}"[^>]*>(.*?)</td>', page)
    return [re.sub("<[^>]*>", "", cell) for cell in found]


def test_a_time_that_was_not_reached_is_never_in_the_tables(review: StudyReview) -> None:
    slow, fast = (run.trial.metrics["settling_time"] for run in review.real)
    assert slow == 1.0
    shown = cells(study_page(review), "settling time [s]")
    assert shown[:2] == ["never (within 1 s)", f"{fast:.4g}"]
    (told,) = [line for line in metric_lines(review, review.real[0].trial) if "settling" in line]
    assert told.endswith(shown[0])


def test_a_time_that_was_not_reached_is_never_on_the_first_screen(review: StudyReview) -> None:
    page = study_page(review)
    row = re.search(r'<th scope="row">settling time \[s\]</th>(.*?)</tr>', page)
    assert row is not None
    first, best, change = re.findall("<td[^>]*>(.*?)</td>", row[1])
    assert re.sub("<[^>]*>", "", first) == "never (within 1 s)"
    assert "never" not in best
    # From never to some time is no change by a share.
    assert re.sub("<[^>]*>", "", change) == "-"
    content = json.loads(PageText(page).embedded["study"])
    assert content["comparison"]["settling_time"]["first"] == 1.0
    assert content["comparison"]["overshoot"]["first"] == 0.0


def test_the_script_gets_the_same_words(review: StudyReview) -> None:
    runs = json.loads(PageText(study_page(review)).embedded["study"])["runs"]
    slow, fast = (run for run in runs if run["source"] == "IS1")
    assert slow["never"]["settling_time"] == "never (within 1 s)"
    assert slow["metrics"]["settling_time"] == 1.0  # the reported metric stays the horizon
    assert fast["never"] == {}


def test_a_remark_calls_it_never_too(review: StudyReview) -> None:
    file = review.file.model_copy(update={"constraints": {"settling_time": 0.2}})
    twice, told = [review.real[0].trial] * 2, review.metric_words
    remarks = remarks_on(file, twice, None, review.space, told)
    assert "no run meets the limit settling time <= 0.2; all have never (within 1 s)" in remarks
    fast = [run.trial for run in review.real]
    assert "no run meets" not in " ".join(remarks_on(review.file, fast, None, review.space, told))
