"""Lines over position and time, and pulses, found where they were hidden and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.screening.line_axes import Axis, over_position, over_time
from gmfbo.diagnosis.screening.port_response import between_points
from gmfbo.diagnosis.screening.repeating_and_passing import find_lines
from tests.diagnosis.port_cases import PortCase, open_servo, port_case


@pytest.fixture
def servo(right_servo: PortCase) -> PortCase:
    return right_servo


def waves(servo: PortCase, lines: dict[float, float]) -> list[NDArray[np.float64]]:
    """Torque of sines over the position: wavenumber to amplitude."""
    positions = [between_points(states.position) for states in servo.states]
    torques = [sum(a * np.sin(k * q + k) for k, a in lines.items()) for q in positions]
    return [np.asarray(torque, dtype=float) for torque in torques]


@pytest.mark.slow
def test_white_residuals_hold_no_lines(servo: PortCase) -> None:
    """False alarms: at most one in 20 nulls, position, time and pulses together."""
    alarms = 0
    for seed in range(20):
        found = find_lines(servo.case, servo.white(seed), servo.response)
        alarms += bool(found.over_position or found.over_time or found.passing)
    assert alarms <= 1


def test_a_right_twin_shows_no_lines(servo: PortCase) -> None:
    found = find_lines(servo.case, servo.case.base, servo.response)
    assert (found.wavenumbers, found.frequencies, found.pulses) == ((), (), ())


@pytest.mark.parametrize("wavenumber", [7.0, 14.0, 36.0])
def test_cogging_is_found_at_its_whole_cycles_a_turn(servo: PortCase, wavenumber: float) -> None:
    base = servo.with_torque(waves(servo, {wavenumber: 0.02}), seed=1)
    found = find_lines(servo.case, base, servo.response)
    assert found.wavenumbers == (wavenumber,)
    assert found.frequencies == ()
    assert found.pulses == ()


def test_a_line_between_whole_cycles_stays_there(servo: PortCase) -> None:
    base = servo.with_torque(waves(servo, {28.4: 0.1}), seed=2)
    found = find_lines(servo.case, base, servo.response)
    np.testing.assert_allclose(found.wavenumbers, [28.4], atol=0.1)


def test_several_lines_come_strongest_first(servo: PortCase) -> None:
    base = servo.with_torque(waves(servo, {7.0: 0.02, 28.0: 0.06, 14.0: 0.04}), seed=3)
    found = find_lines(servo.case, base, servo.response)
    assert set(found.wavenumbers) == {7.0, 14.0, 28.0}
    gains = [line.gain for line in found.over_position]
    assert gains == sorted(gains, reverse=True)


def test_once_a_turn_is_found_in_less_than_a_turn(servo: PortCase) -> None:
    base = servo.with_torque(waves(servo, {1.0: 0.2}), seed=4)
    found = find_lines(servo.case, base, servo.response)
    assert found.wavenumbers == (1.0,)
    assert found.pulses == ()


def test_a_line_over_time_is_told_from_one_over_position(servo: PortCase) -> None:
    torques = [0.05 * np.sin(2.0 * np.pi * 13.3 * s.time + 1.0) for s in servo.states]
    found = find_lines(servo.case, servo.with_torque(torques, seed=5), servo.response)
    assert found.wavenumbers == ()
    np.testing.assert_allclose(found.frequencies, [13.3], atol=0.05)


def test_a_pulse_is_found_in_its_recording_to_a_hundredth_of_a_second(servo: PortCase) -> None:
    torques = [np.zeros(rows) for rows in servo.response.rows]
    time = servo.states[1].time
    torques[1] = np.where((time >= 0.9) & (time < 1.02), 0.1, 0.0)
    found = find_lines(servo.case, servo.with_torque(torques, seed=6), servo.response)
    (pulse,) = found.passing
    assert pulse.record == 1
    assert pulse.start == pytest.approx(0.9, abs=0.01)
    assert pulse.start + pulse.duration == pytest.approx(1.02, abs=0.01)


def test_cogging_hidden_in_the_physics_is_found_through_the_loop() -> None:
    case = open_servo({"cogging_torque.wavenumber_1": 14.0, "cogging_torque.sine_1": 0.01})
    hidden = port_case(case)
    assert find_lines(case, case.base, hidden.response).wavenumbers == (14.0,)
    case.simulations.close()


@pytest.mark.slow
def test_few_lines_a_turn_are_found_in_a_quarter_of_a_turn() -> None:
    """Together they look like an offset, a slope and friction to a twin that lacks them."""
    hidden = {"wavenumber_1": 4.0, "sine_1": 0.02, "wavenumber_2": 8.0, "cosine_2": 0.008}
    hidden |= {"wavenumber_3": 16.0, "sine_3": 0.003}
    case = open_servo({f"cogging_torque.{name}": value for name, value in hidden.items()})
    found = find_lines(case, case.base, port_case(case).response)
    assert case.setting.excitation.stroke < 0.25 * 2.0 * np.pi
    assert set(found.wavenumbers) == {4.0, 8.0, 16.0}
    case.simulations.close()


def test_six_lines_are_found_together(servo: PortCase) -> None:
    hidden = dict.fromkeys((7.0, 14.0, 28.0, 42.0, 56.0, 70.0), 0.06)
    base = servo.with_torque(waves(servo, hidden), seed=8)
    assert set(find_lines(servo.case, base, servo.response).wavenumbers) == set(hidden)


def test_sums_over_an_axis_are_those_of_its_waves(servo: PortCase) -> None:
    rng = np.random.default_rng(7)
    seen = [rng.standard_normal(rows) for rows in servo.response.rows]
    axes = over_position(servo.case, servo.case.base, servo.response), over_time(servo.case)
    for axis in axes:
        assert axis is not None
        chosen = np.array([0, 5, axis.places.size - 1])
        sums = axis.sums(seen)[:, chosen]
        for k, columns in enumerate(axis.waves(axis.places[chosen])):
            there = columns @ seen[k]
            np.testing.assert_allclose(sums[k].imag, there[:3], atol=1e-6)
            np.testing.assert_allclose(sums[k].real, there[3:], atol=1e-6)


def test_a_line_that_passes_too_fast_for_the_samples_is_left_out_there() -> None:
    position = np.concatenate([np.linspace(0.0, 0.1, 100), np.linspace(0.1, 10.0, 100)])
    rates = np.abs(np.gradient(position))
    axis = Axis((position,), (rates,), np.array([50.0, 60.0]), 1.0, False)
    (columns,) = axis.waves(np.array([50.0]))
    assert np.any(columns[0, 1:99] != 0.0)
    assert not np.any(columns[:, 102:])


def test_a_line_that_turns_its_sign_with_the_current_is_found_as_ripple(servo: PortCase) -> None:
    plain = waves(servo, {22.0: 0.3})
    largest = max(float(np.abs(states.current).max()) for states in servo.states)
    torque = [
        wave * between_points(states.current) / largest
        for wave, states in zip(plain, servo.states, strict=True)
    ]
    found = find_lines(servo.case, servo.with_torque(torque, seed=5), servo.response)
    assert found.ripple_wavenumbers[0] == pytest.approx(22.0, abs=0.2)
    ripple, plain_lines = found.with_current[0].gain, [line.gain for line in found.over_position]
    assert ripple > 1.5 * max(plain_lines, default=0.0)


def test_a_right_twin_shows_no_ripple(servo: PortCase) -> None:
    """Negative control."""
    assert find_lines(servo.case, servo.case.base, servo.response).ripple_wavenumbers == ()
