"""Long rests are left out; forces that the twin lacks may be larger than all that it makes."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.opened_comparison import problem_on
from gmfbo.recordings.recording import Recording
from tests.diagnosis.short_recordings import SERVO, decided, moves, multisine, open_small

Array = NDArray[np.float64]

LOAD = {"gravity_torque.sine": -0.3, "coulomb_friction.level": 0.1}
MOVED = [(0.6, 0.8, 0.8), (2.6, -0.5, 0.7), (5.0, 0.9, 0.6)]  # at [s], to [rad], within [s]


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
    segments = problem_on(case, case.budget.windows).segments
    return [(s.time[0], s.time[-1]) for s in segments if s.record == record]


def test_moves_are_compared_from_when_the_axis_lets_go_to_when_it_has_settled() -> None:
    with closing((case := open_small(SERVO.twin(), recorded())).simulations):
        stretches = compared(case)
        assert len(stretches) == len(MOVED)
        for (begin, _, within), (start, end) in zip(MOVED, stretches, strict=True):
            assert begin < start < begin + 0.15
            assert begin + within < end < begin + within + 0.3
        assert sum(note.startswith("long rests") for note in case.notes) == 1


@pytest.mark.parametrize("cut", [2.4, 4.8])
def test_a_recording_that_begins_at_rest_is_compared_from_where_the_axis_lets_go(
    cut: float,
) -> None:
    """Where friction holds it in the first row came of a motion that nobody recorded."""
    made = recorded()[0]
    begin = cut + 0.2
    assert begin in [at for at, _, _ in MOVED]
    kept = made.time >= cut
    signals = {name: column[kept] for name, column in made.signals.items()}
    late = replace(made, time=made.time[kept], signals=signals)
    with closing((case := open_small(SERVO.twin(), [late])).simulations):
        (start, _), *_ = compared(case)
        assert begin < start < begin + 0.15


def test_an_axis_that_is_moved_while_its_twin_rests_is_compared() -> None:
    made = recorded()[0]
    shaken = np.where((made.time > 4.0) & (made.time < 4.5), 0.01, 0.0)
    wave = shaken * np.sin(2.0 * np.pi * 8.0 * made.time)
    signals = {**made.signals, "position": made.signals["position"] + wave}
    with closing((case := open_small(SERVO.twin(), [replace(made, signals=signals)])).simulations):
        assert any(start < 4.2 and end > 4.5 for start, end in compared(case))


def test_a_slow_motion_is_no_rest() -> None:
    def crept(t: NDArray[np.float64]) -> NDArray[np.float64]:
        moved: Array = point_to_point(np.minimum(t, 2.0)) + 1e-3 * np.maximum(t - 3.0, 0.0)
        return moved

    made = SERVO.recordings(LOAD, (crept,), seconds=6.0)
    with closing((case := open_small(SERVO.twin(), made)).simulations):
        (_, first), (second, end) = compared(case)
        assert 1.4 < first < 1.8
        assert 3.0 < second < 3.2
        assert end == pytest.approx(5.999)


def test_a_recording_without_long_rests_and_one_without_motion_stay_whole() -> None:
    made = SERVO.recordings({}, (multisine, moves, lambda t: 0.0 * t), seconds=1.3)
    with closing((case := open_small(SERVO.twin(), [*made, *recorded()])).simulations):
        assert [compared(case, k) for k in range(3)] == 3 * [[pytest.approx((0.0, 1.299))]]


def test_laws_may_be_as_large_as_what_the_drive_was_recorded_to_make() -> None:
    with closing((case := open_small(SERVO.twin(), recorded())).simulations):
        excitation = case.setting.excitation
        largest = float(np.quantile(np.abs(recorded()[0].signals["torque_command"]), 0.995))
        assert excitation.command == pytest.approx(largest, rel=1e-3)
        assert excitation.torque == pytest.approx(largest, rel=0.05)  # the drive's gain is one


def pieces(whole: Recording) -> list[Recording]:
    """Moves cut out of a recording, each amid the rest before it, on clocks of their own."""
    found = []
    for k, (begin, _, _) in enumerate(MOVED):
        rows = (whole.time >= begin - 0.5) & (whole.time < begin + 1.2)
        signals = {name: column[rows] for name, column in whole.signals.items()}
        time = whole.time[rows] - whole.time[rows][0]
        found.append(replace(whole, time=time, signals=signals, name=f"piece{k}.csv"))
    return found


def test_a_twin_begins_where_pieces_of_a_log_do_and_jumps_to_no_place() -> None:
    with closing((case := open_small(SERVO.twin(), pieces(recorded()[0]))).simulations):
        assert case.notes[0].startswith("piece1.csv and piece2.csv: begins at another place")
        assert case.setting.excitation.command < 1.0  # a jump saturates the drive at 10 N m
        assert case.setting.excitation.loop_time < 0.02
        for run, record in zip(case.nominal, case.simulations.records, strict=True):
            assert run.signals[0][0] == pytest.approx(record.signals[0].values[0], abs=0.01)


def test_a_step_after_a_rest_is_compared_from_its_first_rows_on() -> None:
    made = SERVO.recordings(LOAD, (lambda t: np.where(t >= 2.0, 0.2, 0.0),), seconds=4.0)
    with closing((case := open_small(SERVO.twin(), made)).simulations):
        ((start, end),) = compared(case)
        assert 1.97 < start < 2.01
        assert 2.1 < end < 2.6


def test_a_disturbance_while_the_twin_rests_is_compared() -> None:
    hum = {"periodic_disturbance.sine": 0.04, "periodic_disturbance.frequency": 3.0}
    made = SERVO.recordings(hum, (lambda t: 0.8 * np.clip((t - 0.2) * 2.5, 0.0, 1.0),), seconds=4.0)
    with closing((case := open_small(SERVO.twin(), made)).simulations):
        assert sum(end - start for start, end in compared(case)) > 3.5


def test_a_signal_that_is_too_slow_for_pieces_stays_whole() -> None:
    made = recorded()[0]
    rows = np.arange(made.time.size) % 100 == 0
    signals = {**made.signals}
    signals["torque_command"] = np.where(rows, signals["torque_command"], np.nan)
    with closing((case := open_small(SERVO.twin(), [replace(made, signals=signals)])).simulations):
        assert len(compared(case)) == 1


def test_pieces_that_move_one_way_each_reverse_together() -> None:
    with closing((case := open_small(SERVO.twin(), pieces(recorded()[0]))).simulations):
        assert case.setting.excitation.reversals == 2  # there, back, and there again


def test_control_a_recording_that_begins_with_a_step_is_not_held_before_it() -> None:
    made = SERVO.recordings({}, (lambda t: np.full(t.size, 0.3),), seconds=1.3)
    with closing((case := open_small(SERVO.twin(), made)).simulations):
        assert not any("another place" in note for note in case.notes)
        assert case.simulations.records[0].plan.lead == 0


@pytest.mark.slow
def test_friction_and_a_load_are_found_in_moves_with_rests() -> None:
    names = ("coulomb_friction", "gravity_torque", "elastic_return", "sensor_eccentricity")
    with closing((case := open_small(SERVO.twin(), recorded())).simulations):
        decision = decided(case, names)
    found = {one.effect: one.values for one in decision.row.hypothesis.effects}
    assert found.keys() == {"coulomb_friction", "gravity_torque"}
    assert found["coulomb_friction"]["level"] == pytest.approx(0.1, rel=0.03)
    assert found["gravity_torque"]["sine"] == pytest.approx(-0.3, rel=0.03)
