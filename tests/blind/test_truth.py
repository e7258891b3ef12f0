"""The true plants: the twins where nothing is hidden, closed forms where something is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from tests.blind.hidden import EFFECTS
from tests.blind.machines import MACHINES, Knowledge, twin_file, variation
from tests.blind.outside import LAWS_OUTSIDE
from tests.blind.references import QUIET, SHAPES
from tests.blind.truth import KINDS, SAMPLE, Diverged, parameter_names, simulate

INERTIA = 0.01
SIZED_OTHERWISE = (
    *("backlash", "torsional_compliance"),  # a load on a shaft remains
    *("actuator_saturation", "supply_voltage_limit"),  # zero only touches the peak
    *("actuator_lag", "sensor_lag"),  # no faster than the integrator's step
)
FREE = {"kind": KINDS["none"], "inertia": INERTIA, "torque_gain": 1.0}


@pytest.mark.parametrize("name", MACHINES)
def test_with_nothing_hidden_the_truth_is_the_twin(name: str, tmp_path: Path) -> None:
    """Another integrator and other controllers give the same to 1e-9 of the range.

    Noise is above 1e-5 of it. One reference stays within the limit and one passes it.
    """
    machine, rng = MACHINES[name], np.random.default_rng(7)
    values = variation(machine, rng)
    path = tmp_path / "twin.toml"
    path.write_text(twin_file(machine, Knowledge(values), tmp_path), encoding="utf-8")
    with FmuTwin(path) as twin:
        for shape, size in (("moves", 1.0), ("steps", 6.0)):
            reference = size * machine.strokes[shape] * SHAPES[shape](rng, 1500)
            true = simulate(values, reference)
            signals = {"reference": reference}
            if machine.is_open_loop:
                signals = {machine.command_name: true.new, "position": true.reading}
            run = twin.run({}, Recording(np.linspace(0.0, 1.499, 1500), signals))
            assert run.status == "ok"
            error = np.abs(run.signal("position") - true.reading)
            assert np.max(error) < 1e-9 * np.ptp(true.reading)
            if not machine.is_open_loop:
                error = np.abs(run.signal(machine.command_name) - true.held)
                assert np.max(error) < 1e-7 * np.ptp(true.held)


@pytest.mark.parametrize("shape", SHAPES)
def test_references_begin_at_zero_and_at_rest(shape: str) -> None:
    wave = SHAPES[shape](np.random.default_rng(0), 3000)
    assert wave.shape == (3000,)
    assert np.all(wave[: QUIET // 2] == 0.0)
    assert 0.3 < np.max(np.abs(wave)) <= 1.0


@pytest.mark.parametrize("name", [n for n, m in MACHINES.items() if not m.is_open_loop])
def test_recordings_begin_where_the_loop_has_come_to_rest(name: str) -> None:
    """Whatever it was pulled to: an offset of the sensor, which an integral part only creeps to."""
    machine, rng = MACHINES[name], np.random.default_rng(3)
    values = variation(machine, rng)
    offset = 0.3 * machine.strokes["moves"]
    run = simulate({**values, "sensor_zero": offset}, np.zeros(500))
    still = np.hypot(machine.jitter, machine.quantum / np.sqrt(12.0))
    assert np.ptp(run.reading) < 0.3 * still


def test_hard_friction_stops_a_mass_after_the_closed_form_distance() -> None:
    """Pushed with u for T: then it slides v^2 J / (2 F), and rests there for good."""
    push, friction, samples = 0.5, 0.2, 100
    reference = np.where(np.arange(1000) < samples, push, 0.0)
    run = simulate(
        FREE | {"friction_positive": friction, "friction_negative": friction},
        reference,
        preroll=0,
    )
    duration = samples * SAMPLE
    speed = (push - friction) / INERTIA * duration
    slid = 0.5 * speed * duration + 0.5 * INERTIA * speed**2 / friction
    assert run.velocity[samples] == pytest.approx(speed, rel=1e-9)
    assert run.position[-1] == pytest.approx(slid, rel=1e-9)
    stopped = round((duration + INERTIA * speed / friction) / SAMPLE) + 1
    assert np.all(run.velocity[stopped:] == 0.0)
    assert np.ptp(run.position[stopped:]) == 0.0


def test_a_torque_below_the_breakaway_level_moves_nothing() -> None:
    """Breakaway is the sliding level and the Stribeck rise; just above it, the mass moves."""
    friction = {
        "friction_positive": 0.2,
        "friction_negative": 0.1,
        "friction_breakaway": 0.1,
        "friction_speed": 0.05,
    }
    for torque, moves in ((0.299, False), (0.301, True), (-0.199, False), (-0.201, True)):
        run = simulate(FREE | friction, np.full(200, torque), preroll=0)
        assert bool(run.position[-1] != 0.0) is moves
        assert bool(np.min(run.active) > 0.999) is not moves


@pytest.mark.parametrize("delay", [0.0, 0.00137, 0.004999])
def test_a_delay_off_the_grid_shifts_the_answer_by_exactly_that(delay: float) -> None:
    reference = np.where(np.arange(100) < 10, 0.0, 0.3)
    run = simulate(FREE | {"delay": delay}, reference, preroll=0)
    acted = np.clip(np.arange(100) * SAMPLE - 0.010 - delay, 0.0, None)
    np.testing.assert_allclose(run.velocity, 0.3 / INERTIA * acted, rtol=1e-9, atol=1e-12)


def test_a_load_behind_a_gap_is_met_after_half_of_it_and_then_moves_along() -> None:
    gap, motor, load, torque = 0.01, 0.006, 0.004, 0.3
    run = simulate(
        FREE
        | {
            "inertia": motor,
            "load_inertia": load,
            "gap": gap,
            "shaft_stiffness": 5e4,
            "contact_exponent": 1.3,
            "contact_damping": 2.0,
        },
        np.full(400, torque),
        preroll=0,
    )
    free = run.position < 0.5 * gap
    t = SAMPLE * np.arange(400)
    np.testing.assert_allclose(run.velocity[free], torque / motor * t[free], rtol=1e-9)
    acceleration = np.polyfit(t[200:], run.velocity[200:], 1)[0]
    assert acceleration == pytest.approx(torque / (motor + load), rel=1e-3)


def test_an_elastic_shaft_rings_at_its_own_frequency() -> None:
    motor, load, stiffness = 0.006, 0.004, 400.0
    run = simulate(
        FREE | {"inertia": motor, "load_inertia": load, "shaft_stiffness": stiffness},
        np.full(2000, 0.1),
        preroll=0,
    )
    together = 0.1 / (motor + load) * SAMPLE * np.arange(2000)
    power = np.abs(np.fft.rfft((run.velocity - together) * np.hanning(2000))[5:])
    found = (5 + np.argmax(power)) / 2.0
    expected = np.sqrt(stiffness * (1.0 / motor + 1.0 / load)) / (2.0 * np.pi)
    assert found == pytest.approx(expected, abs=0.5)


def test_slipping_elements_draw_a_loop_that_does_not_know_the_rate() -> None:
    """Slow ramps there and back: the command differs by twice the force, at any slow speed."""
    servo = {"kind": KINDS["servo_pd"], "inertia": INERTIA, "torque_gain": 1.0, "kp": 40.0}
    servo |= {"kd": 0.8, "filter_time": 1e-3, "slip_force": 0.1, "slip_length": 0.02}
    for rows in (2000, 4000):
        ramp = np.concatenate([np.linspace(0.0, 0.5, rows), np.linspace(0.5, 0.0, rows)])
        run = simulate(servo, ramp)
        there, back = run.held[rows // 2], run.held[rows + rows // 2]
        assert there - back == pytest.approx(0.2, abs=2e-3)


def test_limits_of_the_drive_bound_what_acts() -> None:
    limited = simulate(FREE | {"drive_limit": 0.1}, np.full(100, 0.3), preroll=0)
    np.testing.assert_allclose(limited.velocity, 0.1 / INERTIA * SAMPLE * np.arange(100), rtol=1e-9)
    np.testing.assert_allclose(limited.active, 1.0, rtol=1e-9)
    slow = simulate(FREE | {"drive_rate": 10.0}, np.full(100, 0.3), preroll=0)
    t = SAMPLE * np.arange(100)
    ramp = np.where(t < 0.03, 5.0 * t**2, 0.3 * t - 0.0045) / INERTIA
    np.testing.assert_allclose(slow.velocity, ramp, rtol=1e-6, atol=1e-9)


def test_a_plant_that_diverges_is_an_error() -> None:
    unstable = {"kind": KINDS["servo_pd"], "inertia": INERTIA, "torque_gain": 1.0, "kd": -1e4}
    with pytest.raises(Diverged, match="diverged"):
        simulate(unstable | {"kp": -1e9}, np.full(3000, 1.0), preroll=0)


def test_an_unknown_parameter_of_the_truth_is_refused() -> None:
    with pytest.raises(KeyError, match="no_such_term"):
        simulate(FREE | {"no_such_term": 1.0}, np.zeros(10), preroll=0)


def test_every_effect_of_size_zero_is_the_plant_without_it() -> None:
    """All names that an effect sets exist, and none acts by being mentioned."""
    from tests.blind.experiments import setting_of

    rng = np.random.default_rng(1)
    machine = MACHINES["servo"]
    reference = SHAPES["moves"](rng, 2000)
    plain = simulate(machine.truth, reference, preroll=0)
    setting = setting_of(machine, machine.truth, [plain])
    for name, hidden in {**EFFECTS, **LAWS_OUTSIDE}.items():
        shaped = hidden.make(setting, rng)
        assert set(shaped(hidden.high(setting))) <= set(parameter_names()), name
        big = simulate({**machine.truth, **shaped(hidden.high(setting))}, reference, preroll=0)
        assert np.max(np.abs(big.reading - plain.reading)) > 1e-5, name
        if name in SIZED_OTHERWISE:
            continue
        tiny = 1e-9 * hidden.low(setting)
        small = simulate({**machine.truth, **shaped(tiny)}, reference, preroll=0)
        assert np.max(np.abs(small.reading - plain.reading)) < 1e-8, name
