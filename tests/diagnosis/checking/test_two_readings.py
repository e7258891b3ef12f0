"""Of a slow logger, only what shows with held and with straight inputs is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gmfbo import FmuTwin, check
from gmfbo.diagnosis.checking.two_readings import slower_inputs, straight
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import QUIET_SERVO, SERVO, Axis


@pytest.fixture(scope="module")
def twin() -> FmuTwin:
    return SERVO.twin()


def every_fifth(recording: Recording) -> Recording:
    signals = {name: column[::5] for name, column in recording.signals.items()}
    return replace(recording, time=recording.time[::5], signals=signals)


@pytest.mark.parametrize("axis", [SERVO, QUIET_SERVO], ids=["noisy", "exact"])
def test_a_slow_logger_makes_no_wrong_column(axis: Axis, twin: FmuTwin) -> None:
    seen = check(twin, [every_fifth(r) for r in axis.recordings({}, seconds=2.0)], jobs=1)
    assert seen.findings == ()
    assert any("leaves open" in note and "reference" in note for note in seen.notes)
    for facts in seen.recordings.values():
        assert not facts.parity > 3.0
        for name, own in facts.alignment.items():
            assert own.scale == pytest.approx(1.0, abs=0.1) or np.isnan(own.scale), name
            assert own.basis == "twin" or abs(own.shift) < 1e-4


def test_a_fault_that_both_show_is_told(twin: FmuTwin) -> None:
    """Negative control: the command is twice as large as it should be."""
    slow = [every_fifth(r) for r in SERVO.recordings({}, seconds=2.0)]
    wrong = [r.with_signals({"torque_command": 2.0 * r.signal("torque_command")}) for r in slow]
    found = check(twin, wrong, jobs=1).findings
    # The second recording rests for the most part: there its rows hide as much.
    assert "rec0.csv" in {f.recording for f in found}
    assert {(f.kind, f.signal) for f in found} == {("controller_parity", "torque_command")}
    assert all("whatever that did between its rows" in f.what for f in found)


def test_a_fault_of_another_kind_is_told_as_before(twin: FmuTwin) -> None:
    slow = [every_fifth(r) for r in SERVO.recordings({}, seconds=2.0)]
    read = np.round(slow[0].signal("position") / 4e-3) * 4e-3
    coarse = [slow[0].with_signals({"position": read}), slow[1]]
    found = check(twin, coarse, jobs=1).findings
    assert ("coarse_column", "rec0.csv", "position") in {
        (f.kind, f.recording, f.signal) for f in found
    }


def test_the_second_reading_is_that_of_linear_interpolation(twin: FmuTwin) -> None:
    """The times of the rows, and of those that halve them, for a line: exact in one alone."""
    time = np.arange(0.0, 1.0, 0.01)
    ramp = Recording(time=time, signals={"reference": 0.3 * time}, parameters=SERVO.gains)
    fine = np.arange(0.0, 0.99, 0.001)
    exact = Recording(time=fine, signals={"reference": 0.3 * fine}, parameters=SERVO.gains)
    drawn = straight(twin, ["reference"])
    expected = twin.run({}, exact).signal("position")
    for own in (drawn, drawn.with_uncertain({})):
        got = own.run({}, ramp).signal("position")[: expected.size]
        np.testing.assert_allclose(got, expected, atol=1e-9)
    held = twin.run({}, ramp).signal("position")[: expected.size]
    assert np.abs(held - expected).max() > 1e-4


def test_one_reading_is_enough_where_rows_are_as_fast_as_the_twin_or_the_file_says_it(
    twin: FmuTwin,
) -> None:
    (recording, *_) = SERVO.recordings({})
    assert slower_inputs(twin, [recording]) == []
    assert slower_inputs(twin, [every_fifth(recording)]) == ["reference"]
    assert slower_inputs(straight(twin, ["reference"]), [every_fifth(recording)]) == []
