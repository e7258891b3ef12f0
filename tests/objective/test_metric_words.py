"""Metrics in words: a time that was not reached is never, and nothing else is."""

from __future__ import annotations

import pytest

from gmfbo.objective.metric_words import MetricWords
from gmfbo.objective.metrics import worst_metrics

ONE = MetricWords.of({"itae": "rad.s2"}, worst_metrics(0.5), [0.5])
TWO = MetricWords.of({}, worst_metrics(0.75), [0.5, 1.0])


@pytest.mark.parametrize("name", ["settling_time", "transient_time", "rise_time"])
def test_a_time_as_long_as_the_horizon_is_never(name: str) -> None:
    assert ONE.text(name, 0.5) == "never (within 0.5 s)"
    assert ONE.text(name, 0.4999) == "0.4999 s"


def test_only_times_of_steps_are_never() -> None:
    assert ONE.text("overshoot", 100.0) == "100.00 %"
    assert ONE.text("itae", 0.5) == "0.5 rad.s2"
    assert ONE.text("own", 0.5) == "0.5"


def test_of_several_references_each_has_its_horizon_and_their_mean_the_mean() -> None:
    assert TWO.text("settling_time[1]", 0.5) == "never (within 0.5 s)"
    assert TWO.text("settling_time[2]", 0.5) == "0.5000 s"
    assert TWO.text("settling_time", 0.5) == "0.5000 s"
    assert TWO.text("settling_time", 0.75) == "never (within 0.75 s)"


def test_a_margin_is_marked_as_the_twins() -> None:
    assert ONE.text("phase_margin", 35.6) == "35.6 deg (from the twin)"
