"""What is said at the end of a study: unmet limits, and queries that ran out first."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.objective.limits import Limits
from gmfbo.objective.metric_words import MetricWords
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.trial import Trial
from gmfbo.space import Gain, GainSpace
from gmfbo.tuning.history.remarks import ended_early, remarks_on, unmet_limits
from gmfbo.tuning.study_file.study_file import parse_study
from gmfbo.tuning.study_file.study_sections import BudgetSection

TOLD = MetricWords.of({}, {"settling_time": 0.5}, [0.5])
LIMITS = Limits({"phase_margin": 60.0, "settling_time": 0.3})
GAINS = {"kp": 80.0}


def run(number: int, margin: float, settling: float, kp: float = 80.0) -> Trial:
    metrics = {"phase_margin": margin, "settling_time": settling}
    return Trial(number, "IS1", {"kp": kp}, Recording(np.zeros(1), {}), 0.0, metrics)


def test_each_limit_that_recommended_gains_miss_is_told_with_their_value() -> None:
    assert unmet_limits(GAINS, [run(1, 35.6, 0.5)], LIMITS, TOLD) == (
        "does not meet the limit phase margin >= 60: 35.6 deg (from the twin)",
        "does not meet the limit settling time <= 0.3: never (within 0.5 s)",
    )


def test_a_limit_that_was_not_measured_is_not_met() -> None:
    (told,) = unmet_limits(GAINS, [run(1, np.nan, 0.2)], LIMITS, TOLD)
    assert told == "does not meet the limit phase margin >= 60: not measured"


def test_the_newest_run_at_the_gains_tells_though_they_differ_in_the_last_digit() -> None:
    real = [run(1, 35.6, 0.2), run(2, 61.0, 0.2, np.nextafter(80.0, 90.0)), run(3, 0.0, 0.2, 90.0)]
    assert unmet_limits(GAINS, real, LIMITS, TOLD) == ()


def test_gains_that_were_not_run_are_not_taken_for_good() -> None:
    (told,) = unmet_limits(GAINS, [run(1, 61.0, 0.2, 90.0)], LIMITS, TOLD)
    assert "not known if they meet the limits" in told


def test_control_without_limits_nothing_is_said() -> None:
    assert unmet_limits(GAINS, [run(1, 35.6, 0.5)], Limits(), TOLD) == ()


def test_queries_that_are_used_up_before_the_real_runs_are_told() -> None:
    budget = BudgetSection(is1_runs=10, iterations=30)
    (told,) = ended_early(budget, 30, 4)
    assert told.startswith("only 4 of 10 real runs were made: no query is left (iterations = 30,")
    assert "raise iterations" in told


@pytest.mark.parametrize(
    ("budget", "queries", "made"),
    [
        ({"is1_runs": 10, "iterations": 30}, 30, 10),  # both at once
        ({"is1_runs": 10, "iterations": 30}, 29, 4),  # still running
        ({"iterations": 30}, 30, 4),  # queries are what is asked for
    ],
)
def test_control_other_ends_are_not_taken_for_it(
    budget: dict[str, int], queries: int, made: int
) -> None:
    assert ended_early(BudgetSection(**budget), queries, made) == []


@pytest.mark.parametrize(("settling", "count"), [(0.48, 1), (0.4, 0)])
def test_samples_that_leave_the_band_in_a_settled_run_are_told(settling: float, count: int) -> None:
    text = '[is1]\ntwin = "a.toml"\n[is2]\ntwin = "a.toml"\n[reference]\nhorizon = 0.5\n'
    study = parse_study(text, label="study", default_name="study")
    best = Trial(
        1,
        "IS1",
        GAINS,
        Recording(np.zeros(1), {}),
        0.0,
        {"settling_time": settling},
        late_error=0.5,
    )
    space = GainSpace((Gain("kp", 10.0, 200.0),))
    told = remarks_on(study, [best], best, space, TOLD)
    assert sum("leaves the band of 2 %" in line for line in told) == count
