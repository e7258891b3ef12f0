"""Parities: each part of the loop held against the recordings on its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin
from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.locating.held_twin import reads_back
from gmfbo.diagnosis.locating.parities import Parities, logged_as, parities
from gmfbo.diagnosis.locating.parity import Parity, block_means, block_spread, fast_noise
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.servo_recordings import (
    GAINS,
    HIDDEN,
    MODELS,
    certain,
    hidden_servo,
    opened_with,
    rewritten,
)

PULSE = {
    "pulse_disturbance.start": 1.0,
    "pulse_disturbance.duration": 0.3,
    "pulse_disturbance.level": 0.3,
}


@contextmanager
def checked(twin: FmuTwin, recordings: list[Recording]) -> Iterator[tuple[Case, Parities]]:
    case = opened_with(twin, recordings)
    try:
        yield case, parities(case, case.base)
    finally:
        case.simulations.close()


def first_of(twin: FmuTwin, recordings: list[Recording]) -> tuple[FmuTwin, list[Recording]]:
    """One recording is enough for what is not there."""
    return twin, recordings[:1]


def test_controller_and_plant_of_a_right_twin_pass(right_case: Case) -> None:
    found = parities(right_case, right_case.base)
    assert not reads_back(right_case, right_case.base)
    assert found.controller is not None
    assert not found.controller.fails
    assert found.plant is not None
    assert not found.plant.fails
    assert set(found.why_not) == {"transmission"}
    assert logged_as(found) == "held"


def test_effort_is_the_torque_that_the_plant_lacks(tmp_path: Path) -> None:
    twin = certain("servo_axis", tmp_path)
    nominal = {name: twin.binding.nominal(name) for name in HIDDEN}
    with checked(*hidden_servo(PULSE, twin=twin, parameters=nominal)) as (_, found):
        assert found.controller is not None
        assert not found.controller.fails
        assert found.plant is not None
        assert found.plant.fails
        assert found.plant.unit == "N.m"
        for grid, column in zip(found.plant.grids, found.plant.columns, strict=True):
            # 0.1 s is several time constants of the loop that holds the plant.
            inside = (grid > 1.1) & (grid < 1.3)
            assert np.mean(column[inside]) == pytest.approx(0.3, rel=0.1)
            assert abs(np.mean(column[(grid > 0.3) & (grid < 0.9)])) < 0.02


def test_controller_with_other_gains_fails_its_parity() -> None:
    # The drive ran with a tenth more gain than the recordings state.
    with checked(*hidden_servo({}, parameters={"kp": 44.0})) as (_, found):
        assert found.controller is not None
        assert found.controller.fails


def test_logger_convention_is_the_one_with_the_smaller_residual() -> None:
    """The recordings of the right twin above are of the other kind."""
    with checked(*hidden_servo({}, new_command=True)) as (_, found):
        assert logged_as(found) == "new"


def test_twin_without_sensor_port_has_its_plant_checked_only(tmp_path: Path) -> None:
    twin = rewritten("servo_axis", tmp_path, {'sensor = "encoder_offset"': ""})
    with checked(*hidden_servo(PULSE, twin=twin)) as (_, found):
        assert found.controller is None
        assert found.why_not["controller"] == "the twin has no sensor port"
        assert logged_as(found) is None
        assert found.plant is not None
        assert found.plant.fails


def test_twin_without_torque_port_has_its_controller_checked_only(tmp_path: Path) -> None:
    twin = rewritten("servo_axis", tmp_path, {'torque = "tau_load"': ""})
    with checked(*first_of(*hidden_servo({}, twin=twin))) as (_, found):
        assert found.plant is None
        assert found.why_not["plant"] == "the twin has no torque port"
        assert found.controller is not None
        assert not found.controller.fails


def test_twin_without_ports_says_why_nothing_was_checked(tmp_path: Path) -> None:
    ports = ('torque = "tau_load"', 'command = "tau_command"', 'sensor = "encoder_offset"')
    twin = rewritten("servo_axis", tmp_path, dict.fromkeys(ports, ""))
    with checked(*first_of(*hidden_servo({}, twin=twin))) as (_, found):
        assert found.controller is None
        assert found.plant is None
        assert set(found.why_not) == {"controller", "plant", "transmission"}


def test_twin_file_without_the_recorded_command_is_told_what_to_write(tmp_path: Path) -> None:
    stated = 'velocity = "velocity"\ncommand = "torque_command"'
    for command, said in (
        ('command = "torque"', "says that the command is torque, which not every recording holds"),
        ("", "the twin file states no command"),
    ):
        changed = {stated: f'velocity = "velocity"\n{command}'}
        twin = rewritten("servo_axis", tmp_path, changed)
        with checked(*first_of(*hidden_servo({}, twin=twin))) as (_, found):
            assert found.controller is None
            assert said in found.why_not["controller"]
            assert 'command = "VARIABLE"' in found.why_not["controller"]


def test_controller_of_a_recording_without_position_is_told_why_it_is_not_checked() -> None:
    twin, (recording, *_) = hidden_servo({})
    kept = {n: c for n, c in recording.signals.items() if n != "position"}
    with checked(twin, [replace(recording, signals=kept)]) as (_, found):
        assert found.controller is None
        assert found.why_not["controller"].startswith("a recording has no position to feed it")
        assert found.why_not["plant"] == "the position was not recorded"


def test_state_that_contains_the_sensor_port_is_recognised(tmp_path: Path) -> None:
    """That of the right twin above does not."""
    twin = rewritten(
        "servo_axis", tmp_path, {'position = "true_position"': 'position = "position"'}
    )
    with checked(*hidden_servo({}, twin=twin)) as (case, found):
        assert reads_back(case, case.base)
        assert found.controller is not None
        assert not found.controller.fails
        assert found.plant is not None
        assert not found.plant.fails


def test_sensor_port_that_feeds_no_controller_is_refused(tmp_path: Path) -> None:
    # The torque port in the sensor's place: what is fed there never reaches the controller.
    twin = rewritten(
        "servo_axis",
        tmp_path,
        {'sensor = "encoder_offset"': 'sensor = "tau_load"', 'torque = "tau_load"': ""},
    )
    with checked(*first_of(*hidden_servo({}, twin=twin))) as (_, found):
        assert found.controller is None
        assert "does not feed every path of the controller" in found.why_not["controller"]


def bench_recordings(level: float) -> list[Recording]:
    time = np.arange(1500, dtype=np.float64) * 1e-3
    current = 1.5 * np.sin(2.0 * np.pi * 2.0 * time) * np.minimum(1.0, time / 0.2)
    plain = Recording(time=time, signals={"current": current}, name="bench.csv")
    with AugmentedTwin(FmuTwin(MODELS / "motor_bench.toml")) as simulator:
        plan = simulator.plan(plain, {})
        run = simulator.run(plan, {}, {"constant_torque_offset.level": level})
    noise = 2e-5 * np.random.default_rng(2).standard_normal(time.size)
    signals = {"current": current, "position": run.held["position"] + noise}
    return [Recording(time=time, signals=signals, name="bench.csv", written_by="test")]


@pytest.mark.parametrize("level", [0.0, 0.05])
def test_open_loop_plant_is_checked_by_the_force_that_holds_it(
    tmp_path: Path, level: float
) -> None:
    twin = certain("motor_bench", tmp_path)
    with checked(twin, bench_recordings(level)) as (_, found):
        assert found.why_not["controller"] == "the twin is an open-loop plant"
        assert found.plant is not None
        assert found.plant.fails == (level > 0.0)
        middle = found.plant.columns[0][400:1400]
        assert np.mean(middle) == pytest.approx(level, abs=0.01)


def test_second_encoder_tells_the_transmission(tmp_path: Path) -> None:
    # One variable stands for both encoders; the recorded load lags by a gap of 2 mrad.
    twin = rewritten(
        "servo_axis",
        tmp_path,
        {
            'position = "position"                       # [rad] encoder': (
                'position = "position"\n"load" = { variable = "true_position" }'
            ),
            'position = "true_position"': 'position = "position"',
            'velocity = "velocity"': 'velocity = "velocity"\nload_position = "true_position"',
        },
    )
    _, recordings = hidden_servo({}, twin=twin)

    def with_load(gap: float) -> list[Recording]:
        changed = []
        for recording in recordings[:1]:
            motor = recording.signal("position")
            load = motor - 0.5 * gap * np.sign(np.gradient(recording.signal("reference")))
            changed.append(recording.with_signals({"load": load}))
        return changed

    with checked(twin, with_load(0.0)) as (_, found):
        assert found.transmission is not None
        assert not found.transmission.fails
    with checked(twin, with_load(2e-3)) as (_, found):
        assert found.transmission is not None
        assert found.transmission.fails


def test_fast_noise_is_the_deviation_of_white_noise() -> None:
    noise = 0.3 * np.random.default_rng(0).standard_normal(20000)
    slow = np.sin(np.linspace(0.0, 6.0, noise.size))
    assert fast_noise(noise + slow) == pytest.approx(0.3, rel=0.03)


def test_scores_of_noise_alone_have_unit_variance() -> None:
    grid = np.arange(30000, dtype=np.float64) * 1e-3
    noise = np.random.default_rng(1).standard_normal(grid.size)
    parity = Parity((noise,), (grid,), 1.0 / np.sqrt(30.0))
    assert parity.excess == pytest.approx(1.0, rel=0.15)
    assert not parity.fails
    assert block_spread([grid], [noise]) == pytest.approx(1.0 / np.sqrt(30.0), rel=0.1)


def test_blocks_that_are_not_scored_are_left_out() -> None:
    grid = np.arange(300, dtype=np.float64) * 1e-3
    column = np.where(grid < 0.1, np.nan, 2.0)
    starts, means = block_means(grid, column)
    assert starts[0] >= 0.09
    np.testing.assert_allclose(means, 2.0)


def test_gains_of_the_servo_are_those_that_recordings_state() -> None:
    _, recordings = hidden_servo({})
    assert all(dict(r.parameters) == GAINS for r in recordings)
