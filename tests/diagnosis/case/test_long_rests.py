"""Long rests are left out; forces that the twin lacks may be larger than all that it makes."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import SERVO, decided, moves, multisine, open_small

Array = NDArray[np.float64]

LOAD = {"gravity_torque.sine": -0.3, "coulomb_friction.level": 0.1}
MOVED = [(0.6, 0.8, 0.8), (2.6, -0.5, 0.9), (5.0, 0.9, 0.8)]  # at [s], to [rad], within [s]


def point_to_point(t: Array) -> Array:
    """Moves of least jerk, with rests of more than a second between them."""
    reference, before = np.zeros(t.size), 0.0
    for begin, end, within in MOVED:
        share = np.clip((t - begin) / within, 0.0, 1.0)
        shape = 10.0 * share**3 - 15.0 * share**4 + 6.0 * share**5
        reference += (end - before) * shape
        before = end
    return reference


def recorded() -> list[Recording]:
    return SERVO.recordings(LOAD, (point_to_point,), seconds=6.8)


def compared(case: Case, record: int = 0) -> list[tuple[float, float]]:
    """[s] Stretches of a recording."""
    return case.simulations.records[record].stretches(0.0, starts_elsewhere=False)


def test_moves_are_compared_with_what_comes_just_before_and_after() -> None:
    with closing((case := open_small(SERVO.twin(), recorded())).simulations):
        stretches = compared(case)
        assert len(stretches) == len(MOVED)
        for (begin, _, within), (start, end) in zip(MOVED, stretches, strict=True):
            assert begin - 0.3 < start < begin
            assert begin + within < end < begin + within + 0.3
        left_out = 6.8 - sum(end - start for start, end in stretches)
        assert any(f"{left_out:.3g} s at rest" in note for note in case.notes)


def test_an_axis_that_is_moved_while_its_twin_rests_is_compared() -> None:
    made = recorded()[0]
    shaken = np.where((made.time > 4.0) & (made.time < 4.5), 0.01, 0.0)
    wave = shaken * np.sin(2.0 * np.pi * 8.0 * made.time)
    signals = {**made.signals, "position": made.signals["position"] + wave}
    with closing((case := open_small(SERVO.twin(), [replace(made, signals=signals)])).simulations):
        assert any(start < 4.0 and end > 4.5 for start, end in compared(case))


def test_a_slow_motion_is_no_rest() -> None:
    def crept(t: Array) -> Array:
        slow: Array = 1e-3 * np.maximum(t - 3.0, 0.0)
        return point_to_point(np.minimum(t, 2.0)) + slow

    made = SERVO.recordings(LOAD, (crept,), seconds=6.0)
    with closing((case := open_small(SERVO.twin(), made)).simulations):
        (_, first), (second, end) = compared(case)
        assert 1.4 < first < 1.8
        assert 2.7 < second < 3.0
        assert end == pytest.approx(5.999)


def test_a_recording_without_long_rests_and_one_without_motion_stay_whole() -> None:
    made = SERVO.recordings({}, (multisine, moves, lambda t: 0.0 * t), seconds=1.3)
    with closing((case := open_small(SERVO.twin(), [*made, *recorded()])).simulations):
        assert [compared(case, k) for k in range(3)] == 3 * [[pytest.approx((0.0, 1.299))]]


def test_laws_may_be_as_large_as_what_the_drive_was_recorded_to_make() -> None:
    with closing((case := open_small(SERVO.twin(), recorded())).simulations):
        excitation = case.setting.excitation
        largest = float(np.quantile(np.abs(recorded()[0].signals["torque_command"]), 0.995))
        assert excitation.command == pytest.approx(largest)
        assert excitation.torque == pytest.approx(largest, rel=0.05)  # the drive's gain is one


def test_friction_and_a_load_are_found_in_moves_with_rests() -> None:
    names = ("coulomb_friction", "gravity_torque", "elastic_return", "sensor_eccentricity")
    with closing((case := open_small(SERVO.twin(), recorded())).simulations):
        decision = decided(case, names)
    found = {one.effect: one.values for one in decision.row.hypothesis.effects}
    assert found.keys() == {"coulomb_friction", "gravity_torque"}
    assert found["coulomb_friction"]["level"] == pytest.approx(0.1, rel=0.03)
    assert found["gravity_torque"]["sine"] == pytest.approx(-0.3, rel=0.03)
