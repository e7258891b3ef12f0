"""A limit that the command passes for one row of the recording is named if it explains enough."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.decision_told import not_testable
from gmfbo.diagnosis.naming.forward_selection import decide
from gmfbo.diagnosis.screening.testable_effects import candidates
from tests.diagnosis import servo_recordings
from tests.diagnosis.servo_recordings import opened

pytestmark = pytest.mark.slow

JUMP_RAD, LIMIT = 0.1, 2.5  # [rad], [N.m]


def kicks() -> tuple[NDArray[np.float64], list[NDArray[np.float64]]]:
    """Three slow motions; in the third the reference jumps for one row."""
    time, columns = servo_recordings.references()
    slow = [0.3 * column for column in columns]
    slow[2][1000] += JUMP_RAD
    return time, slow


@pytest.mark.parametrize(
    "physics", [{"actuator_saturation.limit": LIMIT}, pytest.param({}, marks=pytest.mark.slow)]
)
def test_a_limit_passed_for_one_row_is_named_where_it_is_there(
    physics: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded = kicks()
    monkeypatch.setattr(servo_recordings, "references", lambda: recorded)
    with closing((case := opened(physics)).simulations):
        library = candidates(["actuator_saturation"], case.setting.excitation)
        decision = decide(case, library, np.random.default_rng(0), lambda stage, share: None)
        commands = [run.response.states["command"] for run in case.base.simulated]
    assert sum(np.count_nonzero(np.abs(c) > LIMIT) for c in commands) == 1
    if not physics:  # the negative control: the same kick, all of which the axis got
        assert decision.rounds == []
        return
    (named,) = decision.rounds
    assert named.winner.effect.values["limit"] == pytest.approx(LIMIT, rel=0.02)


@pytest.mark.slow
def test_a_limit_is_looked_for_where_the_library_tries_it_at_sizes_that_nothing_meets(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    recorded = kicks()
    monkeypatch.setattr(servo_recordings, "references", lambda: recorded)
    with closing((case := opened({"actuator_saturation.limit": LIMIT})).simulations):
        library = [Candidate("actuator_saturation", {"limit": 20.0 * LIMIT})]
        decision = decide(case, library, np.random.default_rng(0), lambda stage, share: None)
    assert decision.like_parameters == {
        "actuator_saturation": "changes nothing in these recordings"
    }
    (named,) = decision.rounds
    assert named.winner.effect.values["limit"] == pytest.approx(LIMIT, rel=0.02)
    assert not_testable(case, {}, decision) == ()
    decision.rounds.clear()
    (entry,) = not_testable(case, {}, decision)
    assert entry.name == "actuator_saturation"
