"""Seconds by stage: by a clock that the test turns, and of a real diagnosis."""

from __future__ import annotations

import pytest

from gmfbo.diagnosis.stage_times import StageTimes


class Clock:
    """Stands still until it is turned."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def test_each_stage_has_the_time_until_the_next_one_and_a_second_visit_is_added() -> None:
    clock, told, ended = Clock(), [], []
    times = StageTimes(
        lambda *stage: told.append(stage), "reading", lambda *stage: ended.append(stage), clock
    )
    for lasting, stage, share in (
        (2.0, "screening", 0.2),
        (1.0, "screening", 0.3),
        (4.0, "fitting", 0.4),
        (8.0, "screening", 0.5),
        (16.0, "done", 1.0),
    ):
        clock.now += lasting
        times(stage, share)
    assert times.seconds == {"reading": 2.0, "screening": 21.0, "fitting": 8.0}
    assert sum(times.seconds.values()) == pytest.approx(clock.now - 100.0)
    assert ended == [("reading", 2.0), ("screening", 5.0), ("fitting", 8.0), ("screening", 16.0)]
    assert told[-1] == ("done", 1.0)
    assert len(told) == 5


def test_a_stage_that_goes_on_has_no_seconds_yet() -> None:
    times = StageTimes(lambda stage, share: None, "reading")
    times("reading", 0.1)
    assert times.seconds == {}
