"""A column that never changes is told; only the controller tells a dead channel from a stall."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo import FmuTwin, check
from gmfbo.diagnosis.checking.consistent_recordings import consistent
from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.still_signals import still_signals
from tests.diagnosis.short_recordings import SERVO, Axis, moves

SAID = "is 0 in every row, while reference moves"


@pytest.fixture(scope="module")
def twin() -> FmuTwin:
    return SERVO.twin()


@pytest.fixture(scope="module")
def moved() -> Recording:
    return SERVO.recordings({}, [moves])[0]


@pytest.fixture(scope="module")
def stalled() -> Recording:
    """An axis so heavy that its encoder sees no motion; the command is that of the controller."""
    axis = Axis(truth={"inertia": 1e4}, noise={})
    (run,) = axis.recordings({}, [moves])
    return run.with_signals({"position": np.round(run.signal("position"), 2)})


def without_motion(recording: Recording) -> Recording:
    return recording.with_signals({"position": np.zeros(len(recording))})


def test_a_dead_channel_is_refused_where_the_command_belongs_to_a_motion(
    twin: FmuTwin, moved: Recording
) -> None:
    with pytest.raises(RecordingError, match=r"^rec0.csv: position .* nor is the command computed"):
        consistent(twin, [without_motion(moved)], seed=0, jobs=1)


def test_an_axis_that_stalls_is_told_and_used(twin: FmuTwin, stalled: Recording) -> None:
    given = consistent(twin, [stalled], seed=0, jobs=1)
    (note,) = given.notes
    assert note.startswith(f"rec0.csv: position {SAID}; map another column, or check its channel")
    assert list(given.recordings) == [stalled]


def test_a_check_says_it_before_all_that_follows_from_it(twin: FmuTwin, stalled: Recording) -> None:
    first = check(twin, [stalled], jobs=1).findings[0]
    assert (first.kind, first.signal, first.what) == ("still_column", "position", SAID)


def test_a_column_that_moves_or_that_nothing_drives_is_not_still(
    twin: FmuTwin, moved: Recording
) -> None:
    """Negative control."""
    assert still_signals(twin, moved) == {}
    at_rest = without_motion(moved).with_signals({"reference": np.zeros(len(moved))})
    assert still_signals(twin, at_rest) == {}
