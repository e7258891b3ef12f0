"""The safety envelope finds the first row outside, and says which signal it was."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.objective.condition import Condition
from gmfbo.objective.envelope import Envelope
from gmfbo.recordings.recording import Recording, Trajectory

TIME = np.arange(5.0) * 0.1
SIGNALS = {"torque": np.array([0.0, 20.0, np.nan, -70.0, 90.0])}


def test_a_run_inside_comes_back_as_it_is() -> None:
    run = Recording(time=TIME, signals=SIGNALS)
    assert Envelope({"torque": (-100.0, 100.0)}).judge(run) is run
    assert Envelope().judge(run) is run


def test_a_simulated_run_is_cut_where_it_leaves() -> None:
    run = Trajectory(time=TIME, signals=SIGNALS, units={"torque": "N.m"}, parameters={"k": 3.0})
    judged = Envelope({"torque": (-60.0, 60.0)}).judge(run)
    assert isinstance(judged, Trajectory)
    assert judged.status == "unsafe"
    assert judged.stopped_at == pytest.approx(0.3)
    assert len(judged) == 4
    assert judged.parameters == {"k": 3.0}
    assert judged.message == (
        "left the safety envelope at 0.3 s: torque = -70 N.m outside [-60, 60]"
    )


def test_a_measured_run_is_marked_and_kept_whole() -> None:
    judged = Envelope({"torque": (-60.0, 60.0)}).judge(Recording(time=TIME, signals=SIGNALS))
    assert isinstance(judged, Trajectory)
    assert (judged.status, len(judged)) == ("unsafe", 5)


def test_the_first_exit_of_all_terms_counts() -> None:
    envelope = Envelope({"torque": (-60.0, 60.0)}, Condition.parse("torque < 10"))
    found = envelope.first_exit(Recording(time=TIME, signals=SIGNALS))
    assert found is not None
    assert (found.row, found.reason) == (1, "not torque < 10")


def test_a_run_whose_safety_cannot_be_judged_is_refused_not_passed() -> None:
    run = Recording(time=TIME, signals=SIGNALS)
    envelope = Envelope({"torqe": (-60.0, 60.0)})
    with pytest.raises(RecordingError, match=r"speaks of 'torqe'.*did you mean 'torque'\?"):
        envelope.judge(run)
    assert envelope.first_exit(run, all_signals=False) is None
