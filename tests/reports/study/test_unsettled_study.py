"""Where no real run settled, page and live page say so first and call the best run least bad."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gmfbo.reports.study.live_page import live_page
from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.review import StudyReview
from tests.pages.page_text import PageText
from tests.reports.study.example_studies import ExampleStudy


def example(folder: Path, *late_errors: float, end: bool = True) -> StudyReview:
    """A study whose real runs have these late errors; above 1 a run did not settle."""
    made = ExampleStudy(folder / "example.study")
    with made.store:
        made.trial("IS2", made.gains(), late_error=0.0)
        for late_error in late_errors:
            real = made.real(made.gains(), None, late_error=late_error)
        if end:
            made.end(real.gains)
    return StudyReview.read(folder / "example.study")


@pytest.fixture
def unsettled(tmp_path: Path) -> StudyReview:
    return example(tmp_path, 40.0, 3.0, 50.0)


def plain(page: str) -> str:
    return " ".join(" ".join(PageText(page).text).split())


def heading(page: str) -> str:
    return plain(page[page.index("<h1") :].partition("</h1>")[0] + "</h1>")


def badge(page: str) -> str:
    return page.partition('<span class="badge ')[2].partition("</span>")[0]


def test_the_page_is_headed_by_it_and_the_badge_says_it(unsettled: StudyReview) -> None:
    page = study_page(unsettled)
    assert heading(page).startswith(
        "No real run settled (of 3 ), so no gains are recommended. Least bad: ctl.Kp ="
    )
    assert badge(page) == 'missing_physics">ended, none settled'
    assert "Best gains" not in page
    assert "best real run" not in page


def test_each_run_that_did_not_settle_says_so_in_the_table(tmp_path: Path) -> None:
    review = example(tmp_path, 40.0, 0.5)
    page = study_page(review)
    read = PageText(page)
    table = page[page.index("The runs in numbers") :].partition("</table>")[0]
    assert table.count(">not settled<") == 1
    assert table.count(">ok<") == 1
    runs = {run["number"]: run["settled"] for run in json.loads(read.embedded["study"])["runs"]}
    assert [runs[run.trial.number] for run in review.real] == [False, True]


def test_the_live_page_is_headed_by_it(unsettled: StudyReview) -> None:
    ended, running = (live_page(unsettled, state, None) for state in ("ended", "running"))
    assert heading(ended).startswith(
        "No real run settled (of 3), so no gains are recommended. Least bad: ctl.Kp ="
    )
    assert badge(ended) == 'missing_physics">ended, none settled'
    assert heading(running).startswith("No real run has settled yet. Least bad so far: ctl.Kp =")


def test_a_study_that_goes_on_says_only_that_none_has_settled_yet(tmp_path: Path) -> None:
    page = study_page(example(tmp_path, 40.0, end=False))
    assert heading(page).startswith("No real run of 1 has settled yet. Least bad so far:")
    assert badge(page) == 'missing_physics">not ended, none settled'


@pytest.mark.parametrize("late_errors", [(40.0, 0.5), ()])
def test_control_with_a_settled_run_the_page_is_headed_by_the_best_gains(
    tmp_path: Path, late_errors: tuple[float, ...]
) -> None:
    if late_errors:
        review = example(tmp_path, *late_errors)
    else:  # a study of before it was asked whether a run settled
        made = ExampleStudy(tmp_path / "example.study")
        with made.store:
            made.end(made.real(made.gains(), None).gains)
        review = StudyReview.read(tmp_path / "example.study")
    page = study_page(review)
    assert heading(page).startswith("Best gains: ctl.Kp =")
    assert badge(page) == 'none">ended'
    assert heading(live_page(review, "ended", None)).startswith("Best gains: ctl.Kp =")
