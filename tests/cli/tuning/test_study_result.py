"""What a study came to, as the terminal says it: what has to be known first comes first."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from gmfbo.cli.tuning import study_result
from gmfbo.cli.tuning.study_result import print_result
from gmfbo.recordings.store.trial import Trial
from gmfbo.reports.study.review import StudyReview
from gmfbo.tuning.query.request import TuningResult
from tests.reports.study.example_studies import write_example_study


@pytest.fixture(scope="module")
def review(tmp_path_factory: pytest.TempPathFactory) -> StudyReview:
    return StudyReview.read(write_example_study(tmp_path_factory.mktemp("studies")))


def printed(
    review: StudyReview, monkeypatch: pytest.MonkeyPatch, best: Trial | None, *, settled: bool
) -> list[str]:
    screen = Console(file=io.StringIO(), width=200)
    monkeypatch.setattr(study_result, "console", screen)
    result = TuningResult(
        best, None, is1_runs=5, queries=3, cost=6.0, settled=settled,
        twin_versions=("friction found",), learned=("mech.J: 0.12 -> 0.148",),
    )  # fmt: skip
    print_result(review, result)
    return screen.file.getvalue().splitlines()  # type: ignore[attr-defined,no-any-return]


def test_that_no_run_settled_comes_before_all_else(
    review: StudyReview, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = printed(review, monkeypatch, review.best, settled=False)
    assert lines[0] == (
        "no real run settled (of 5), so no gains are recommended; below is the least bad run"
    )
    assert sum("no real run settled" in line for line in lines) == 1
    assert any(line.startswith("least bad  ") for line in lines)
    assert not any(line.startswith(("best observed", "recommended")) for line in lines)


def test_that_no_run_succeeded_comes_before_all_else(
    review: StudyReview, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = printed(review, monkeypatch, None, settled=False)
    assert lines[0] == "no real run succeeded, so there are no gains to take"


def test_control_of_a_study_with_a_settled_run_the_name_comes_first(
    review: StudyReview, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = printed(review, monkeypatch, review.best, settled=True)
    assert lines[0].startswith("example: gmfbo_paper, 5 real runs")
    assert any(line.startswith("best observed") for line in lines)
