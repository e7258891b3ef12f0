"""Metrics on the page of a study: heads with their unit, and values as the terminal words them."""

from __future__ import annotations

from gmfbo.objective.margins import MARGINS
from gmfbo.objective.metric_words import OF_TWIN, never_words
from gmfbo.pages.marked_number import Path, marked_number, unit_text
from gmfbo.plain_words import words
from gmfbo.reports.study.review import StudyReview


def metric_head(review: StudyReview, name: str) -> str:
    """Name of a metric with its unit, as text; a margin is marked as the twin's.

    Parameters
    ----------
    review : StudyReview
        Knows the units.
    name : str
        As it is stored.
    """
    unit = unit_text(review.unit_of(name))
    of_twin = f" ({OF_TWIN})" if name in MARGINS else ""
    return (f"{words(name)} [{unit}]" if unit else words(name)) + of_twin


def metric_cell(review: StudyReview, name: str, path: Path, value: float) -> str:
    """Value of a metric as HTML; `never` for a time that was not reached.

    Parameters
    ----------
    review : StudyReview
        Knows which times were not reached.
    name : str
        As it is stored.
    path : sequence of str or int
        Place of the value in the page's JSON.
    value : float
        [unit of the metric] NaN for none, which is shown as a dash.
    """
    number = marked_number(path, value, digits=4)
    return never_words(number) if review.metric_words.is_never(name, value) else number
