"""The lines at the end of the terminal's output are on the page too, escaped."""

from __future__ import annotations

from dataclasses import replace
from html import escape
from pathlib import Path

import pytest

from gmfbo.reports.study.live_page import live_page
from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.study_remarks import study_remarks
from tests.reports.study.example_studies import ExampleStudy

SLOW = {"ctl.Kp": 100.0, "ctl.Kd": 60.0}  # both at an end of their range


@pytest.fixture
def review(tmp_path: Path) -> StudyReview:
    """One failed run and two equal ones, with a limit that these miss, out of queries."""
    made = ExampleStudy(tmp_path / "example.study")
    with made.store as store:
        made.trial("IS2", made.gains())
        made.real({"ctl.Kp": 500.0, "ctl.Kd": 30.0}, None, "failed")
        made.real(SLOW, None)
        last = made.real(SLOW, None)
        store.log("worth", number=last.number, gain=0.01, noise=0.05, confirms=True)
        made.end(last.gains)
    found = StudyReview.read(tmp_path / "example.study")
    budget = found.file.budget.model_copy(update={"is1_runs": 9, "iterations": 1})
    update = {"constraints": {"overshoot": -1.0}, "budget": budget}
    return replace(found, file=found.file.model_copy(update=update))


@pytest.mark.parametrize(
    "said",
    [
        "1 of 3 real runs failed; the last one: failed",
        "no run meets the limit overshoot <= -1; the nearest has 0.00 %",
        "all 2 runs score the same",
        "the best ctl.Kp = 100 lies at the lower end of its range [100, 900]",
        "the best ctl.Kd = 60 lies at the upper end of its range [4, 60]",
        "only 3 of 9 real runs were made: no query is left (iterations = 1,",
        "a further run is expected to gain 0.01, less than the noise of one run (0.05); the last "
        "run repeated the recommended gains",
    ],
)
def test_each_remark_is_in_its_section_of_the_page(review: StudyReview, said: str) -> None:
    for page in (study_page(review), live_page(review, "ended", None)):
        shown = page.partition('<section id="remarks">')[2].partition("</section>")[0]
        assert f"<li>{escape(said)}" in shown


def test_a_page_that_still_runs_waits_with_the_remarks(review: StudyReview) -> None:
    assert 'id="remarks"' not in live_page(review, "running", None)


def test_control_without_a_remark_there_is_no_section(tmp_path: Path) -> None:
    made = ExampleStudy(tmp_path / "example.study")
    with made.store:
        made.trial("IS2", made.gains())
        made.real({"ctl.Kp": 400.0, "ctl.Kd": 20.0}, None)
        made.real({"ctl.Kp": 500.0, "ctl.Kd": 30.0}, None)
    review = StudyReview.read(tmp_path / "example.study")
    assert study_remarks(review) == ()
    assert 'id="remarks"' not in study_page(review)
