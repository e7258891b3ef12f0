"""Runs that none beats, by definition and on the page of a study."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gmfbo.reports.study.page import study_page
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.trade_offs import trade_offs, unbeaten
from tests.reports.study.example_studies import write_example_study


@given(arrays(float, (12, 2), elements=st.integers(0, 5).map(float)))
def test_none_beats_a_marked_run_and_a_marked_one_beats_each_other(values: np.ndarray) -> None:
    kept = unbeaten(values)
    for row, value in enumerate(values):
        beaten_by = np.all(values <= value, axis=1) & np.any(values < value, axis=1)
        assert kept[row] == (not beaten_by.any())
        assert kept[row] or kept[beaten_by].any()


def test_the_page_shows_each_pair_of_metrics_with_the_unbeaten_runs(tmp_path: Path) -> None:
    review = StudyReview.read(write_example_study(tmp_path))
    page = study_page(review)
    figures = re.findall(r'<figure data-x="(\w+)" data-y="(\w+)"( hidden)?>(.*?)</figure>', page)
    good = [run.trial for run in review.real if run.trial.status == "ok"]
    telling = [n for n in review.metrics if len({trial.metrics[n] for trial in good}) > 1]
    assert [(x, y) for x, y, *_ in figures] == list(combinations(telling, 2))
    assert [hidden for *_, hidden, _ in figures].count("") == 1
    x, y, _, drawn = figures[0]
    kept = unbeaten(np.array([[trial.metrics[x], trial.metrics[y]] for trial in good]))
    marked = re.findall(r'class="mark IS1[^"]* unbeaten"[^>]* data-run="(\d+)"', drawn)
    expected = {str(one.number) for one, best in zip(good, kept, strict=True) if best}
    assert set(marked) == expected


def test_a_run_that_never_reached_a_time_is_not_drawn_at_the_horizon(tmp_path: Path) -> None:
    review = StudyReview.read(write_example_study(tmp_path))
    good = [run for run in review.real if run.trial.status == "ok"]
    horizon = max(run.trial.metrics["settling_time"] for run in good)
    never = [run.trial.number for run in good if run.trial.metrics["settling_time"] == horizon]
    assert 0 < len(never) < len(good) - 1
    words = replace(review.metric_words, longest={"settling_time": horizon})
    review.__dict__["metric_words"] = words
    figures = re.findall(
        r'<figure data-x="(\w+)" data-y="(\w+)"[^>]*>(.*?)</figure>', trade_offs(review)
    )
    for x, y, drawn in figures:
        marked = set(map(int, re.findall(r'data-run="(\d+)"', drawn)))
        assert marked.isdisjoint(never) == ("settling_time" in (x, y))
    assert "never reached one of both times" in trade_offs(review)
