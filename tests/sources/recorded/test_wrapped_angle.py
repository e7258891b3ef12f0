"""Angles that a logger wraps are unwrapped with a note; what only looks like it is left alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin, check
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.wrapped_angle import unwrapped, without_jumps
from tests.diagnosis.servo_recordings import rewritten
from tests.diagnosis.short_recordings import SERVO

Array = NDArray[np.float64]
TURN = 2.0 * np.pi


@pytest.fixture(scope="module")
def twin() -> FmuTwin:
    return SERVO.twin()


def turning(t: Array) -> Array:
    """Ramp up, and back, over two turns."""
    ramp: Array = 12.0 * np.clip(t - 0.1, 0.0, 0.6) / 0.6 - 12.0 * np.clip(t - 0.8, 0.0, 0.5) / 0.5
    return ramp


@pytest.fixture(scope="module")
def turned() -> Recording:
    return SERVO.recordings({}, [turning])[0]


def centred(column: Array) -> Array:
    """Wrap into -pi to pi."""
    return np.asarray((column + np.pi) % TURN - np.pi, dtype=np.float64)


def test_wrapped_position_is_as_it_was_before_with_a_note(twin: FmuTwin, turned: Recording) -> None:
    wrapped = turned.with_signals({"position": centred(turned.signal("position"))})
    whole, notes = unwrapped(wrapped, twin)
    np.testing.assert_allclose(whole.signal("position"), turned.signal("position"), atol=1e-9)
    assert notes == ("rec0.csv: position jumps by a full turn: it wraps; unwrapped",)
    np.testing.assert_array_equal(whole.signal("reference"), turned.signal("reference"))


def test_position_and_reference_that_wrap_together_stay_together(
    twin: FmuTwin, turned: Recording
) -> None:
    """The position begins a little below zero there, which wraps to a full turn."""
    both = {n: (turned.signal(n) - 1e-3) % TURN for n in ("position", "reference")}
    both["reference"] = turned.signal("reference") % TURN
    whole, notes = unwrapped(turned.with_signals(both), twin)
    error = whole.signal("position") - whole.signal("reference")
    expected = turned.signal("position") - turned.signal("reference")
    np.testing.assert_allclose(error, expected - 1e-3, atol=1e-9)
    assert len(notes) == 2


def test_position_that_does_not_wrap_is_left_alone(twin: FmuTwin, turned: Recording) -> None:
    assert unwrapped(turned, twin) == (turned, ())


def test_reference_that_is_asked_to_jump_by_a_turn_is_left_alone(
    twin: FmuTwin, turned: Recording
) -> None:
    step = np.where(turned.time < 0.5, 0.0, TURN)
    asked = turned.with_signals({"reference": step})
    assert unwrapped(asked, twin) == (asked, ())


@pytest.mark.parametrize(
    "column",
    [
        np.linspace(0.0, 5.0, 500),
        np.where(np.arange(500) == 250, 4.0, np.linspace(0.0, 1.0, 500)),
        np.linspace(0.0, 20.0, 500),
        6.0 * np.random.default_rng(0).random(500),
    ],
    ids=["ramp", "outlier", "several turns", "noise"],
)
def test_what_does_not_move_on_beyond_a_jump_does_not_wrap(column: Array) -> None:
    assert without_jumps(column, "rad") is None


def test_rows_that_were_not_sampled_stay_so() -> None:
    ramp = np.linspace(0.0, 20.0, 500)
    wrapped = centred(ramp)
    wrapped[::7] = np.nan
    whole = without_jumps(wrapped, "rad")
    assert whole is not None
    assert np.isnan(whole[::7]).all()
    known = np.isfinite(whole)
    np.testing.assert_allclose(whole[known] - whole[1], ramp[known] - ramp[1], atol=1e-9)


def test_degrees_count_where_no_unit_is_stated() -> None:
    ramp = np.linspace(0.0, 1000.0, 500)
    whole = without_jumps(ramp % 360.0, "")
    assert whole is not None
    np.testing.assert_allclose(whole, ramp, atol=1e-9)
    assert without_jumps(ramp % 360.0, "rad") is None


def test_check_finds_nothing_wrong_with_a_wrapped_position(
    twin: FmuTwin, turned: Recording
) -> None:
    wrapped = turned.with_signals({"position": centred(turned.signal("position"))})
    seen = check(twin, [wrapped], jobs=1)
    assert not [f for f in seen.findings if f.kind != "no_reversal"]
    assert "rec0.csv: position jumps by a full turn: it wraps; unwrapped" in seen.notes


def stated(wrapped: bool, tmp_path: Path) -> FmuTwin:
    entry = f'position = {{ variable = "position", wrapped = {str(wrapped).lower()} }}'
    plain = '[outputs]\nposition = "position"'
    return rewritten("servo_axis", tmp_path, {plain: f"[outputs]\n{entry}"})


def test_wrapped_true_unwraps_what_moves_too_fast_to_be_recognised(
    turned: Recording, tmp_path: Path
) -> None:
    """Every 100th row: steps of up to 0.38 of a turn."""
    position = turned.signal("position")[::100]
    assert without_jumps(centred(position), "rad") is None
    few = Recording(
        time=turned.time[::100], signals={"position": centred(position)}, name="few.csv"
    )
    whole, notes = unwrapped(few, stated(True, tmp_path))
    np.testing.assert_allclose(whole.signal("position"), position, atol=1e-9)
    assert notes == ("few.csv: position jumps by a full turn: it wraps; unwrapped",)


def test_wrapped_false_leaves_an_angle_as_it_is(turned: Recording, tmp_path: Path) -> None:
    wrapped = turned.with_signals({"position": centred(turned.signal("position"))})
    assert unwrapped(wrapped, stated(False, tmp_path)) == (wrapped, ())


def test_wrapped_true_changes_nothing_where_nothing_jumps(
    turned: Recording, tmp_path: Path
) -> None:
    whole, notes = unwrapped(turned, stated(True, tmp_path))
    assert notes == ()
    np.testing.assert_array_equal(whole.signal("position"), turned.signal("position"))
