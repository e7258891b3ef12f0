"""A physical term that is off leaves no trace, to the last bit; ports act as documented."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing

import numpy as np
import pytest

from gmfbo import Trajectory
from gmfbo.sources.fmu_file.models import models_folder
from tests.drive_twin.drive_runs import CORNERS, IDEAL_ENCODERS, NO_RIPPLE, OUTPUTS, Drive
from tests.fmu_build.fmu_instance import FmuInstance, unpacked_fmu

COUNT = 2.0 * np.pi / 4096
DRY = {"friction.coulomb": 0.0, "friction.stribeck": 0.0}


def assert_same(left: Trajectory, right: Trajectory) -> None:
    for name in OUTPUTS:
        np.testing.assert_array_equal(left.signal(name), right.signal(name), err_msg=name)


@pytest.mark.parametrize(
    ("off", "irrelevant"),
    [
        ({"ripple.amplitude": 0.0}, {"ripple.order": 2.0, "ripple.phase": 1.0}),
        (
            {"cogging.amplitude[1]": 0.0},
            {"cogging.order[1]": 7.0, "cogging.phase[1]": 1.0},
        ),
        ({"friction.stribeck": 0.0}, {"friction.stribeck_velocity": 7.0}),
        ({**DRY}, {"friction.presliding": 0.05, "friction.stribeck_velocity": 9.0}),
        ({}, {"load.unbalance_angle": 1.0}),
        ({}, {"gear.stiffness": 500.0, "gear.damping": 0.0}),
        ({"friction.scale": 0.0}, {"friction.viscous": 9.0, "friction.coulomb": 9.0}),
        ({"friction.scale": 0.0}, {"load.viscous": 9.0, "load.coulomb": 9.0}),
        ({"ctl.delay": 0.0}, {"initial.velocity": 0.0}),
    ],
    ids=lambda value: ",".join(value) if isinstance(value, dict) else None,
)
def test_a_term_that_is_off_leaves_no_trace(
    drive: Drive, off: Mapping[str, float], irrelevant: Mapping[str, float]
) -> None:
    assert_same(drive.run(off), drive.run({**off, **irrelevant}))


def test_a_delay_of_the_drive_is_one_of_the_controller_that_the_log_does_not_show(
    drive: Drive,
) -> None:
    sampled = {**IDEAL_ENCODERS, "drive.sample_time": 1e-4}
    at_controller = drive.run({**sampled, "ctl.delay": 3.0})
    in_drive = drive.run({**sampled, "ctl.delay": 0.0, "drive.delay": 3e-3})
    np.testing.assert_allclose(
        in_drive.signal("true_position"), at_controller.signal("true_position"), atol=1e-12
    )
    # The log is above the drive: the same command, three samples earlier.
    np.testing.assert_allclose(
        in_drive.signal("torque_command")[:-3],
        at_controller.signal("torque_command")[3:],
        atol=1e-9,
    )


def test_friction_scaled_to_zero_is_no_friction(drive: Drive) -> None:
    none = {**DRY, "friction.viscous": 0.0}
    assert_same(drive.run({"friction.scale": 0.0}), drive.run(none))


def test_friction_scale_multiplies_all_friction(drive: Drive) -> None:
    doubled = {"friction.viscous": 0.3, "friction.coulomb": 2.4, "friction.stribeck": 0.6}
    left, right = drive.run({"friction.scale": 2.0}), drive.run(doubled)
    np.testing.assert_allclose(
        left.signal("true_position"), right.signal("true_position"), atol=1e-10
    )


def test_friction_may_change_during_the_run(drive: Drive) -> None:
    scale = np.where(np.arange(1101) >= 600, 3.0, 1.0)
    changed, constant = drive.run(schedules={"friction.scale": scale}), drive.run()
    before = slice(0, 601)
    np.testing.assert_array_equal(
        changed.signal("true_position")[before], constant.signal("true_position")[before]
    )
    assert changed.signal("torque")[-1] != constant.signal("torque")[-1]


def test_friction_of_the_load_is_friction_of_a_rigid_drive(drive: Drive) -> None:
    of_motor = {"friction.viscous": 0.4, "friction.coulomb": 1.0, "friction.stribeck": 0.0}
    of_load = {**DRY, "friction.viscous": 0.0, "load.viscous": 0.4, "load.coulomb": 1.0}
    left, right = (
        drive.run({**IDEAL_ENCODERS, **of_motor}),
        drive.run({**IDEAL_ENCODERS, **of_load}),
    )
    np.testing.assert_allclose(
        left.signal("true_position"), right.signal("true_position"), atol=1e-9
    )


@pytest.mark.parametrize("gains", CORNERS)
def test_a_stiff_shaft_tends_to_a_rigid_one(drive: Drive, gains: tuple[float, float]) -> None:
    """Four times the stiffness, about a quarter of the difference."""
    rigid = drive.run(IDEAL_ENCODERS, gains=gains).signal("true_position")
    errors = []
    for stiffness in (25e3, 100e3):
        shaft = {"gear.flexible": 1.0, "gear.stiffness": stiffness, "gear.damping": 20.0}
        run = drive.run({**IDEAL_ENCODERS, **shaft, "solver.substeps": 2}, gains=gains)
        moving = slice(0, 250)
        errors.append(np.abs(run.signal("true_position")[moving] - rigid[moving]).max())
    assert errors[1] < 0.4 * errors[0]
    assert errors[0] < 4e-3


def test_backlash_lets_the_load_lag_by_half_the_gap(drive: Drive) -> None:
    gap = 4e-3
    run = drive.run({**IDEAL_ENCODERS, "gear.backlash": gap, "gear.damping": 100.0})
    twist = run.signal("true_motor_position") - run.signal("true_position")
    driven = run.signal("torque") > 5.0
    wound = twist[driven][-20:] if driven.sum() > 20 else twist[driven]
    assert np.abs(twist).max() < 0.5 * gap + 70.0 / 20000.0
    assert wound.min() > 0.49 * gap


def test_unbalance_holds_the_arm_by_a_torque(drive: Drive) -> None:
    """At rest Kp (q* - q) = U sin(q + angle), without friction."""
    weight, angle = 5.0, 0.3
    parameters = {"load.unbalance": weight, "load.unbalance_angle": angle, "friction.scale": 0.0}
    run = drive.run({**IDEAL_ENCODERS, **NO_RIPPLE, **parameters}, duration=4.0)
    position = run.signal("true_position")[-1]
    assert 100.0 * (1.0 - position) == pytest.approx(weight * np.sin(position + angle), rel=1e-7)


def test_load_torque_acts_on_the_joint(drive: Drive) -> None:
    parameters = {**NO_RIPPLE, "friction.scale": 0.0, "load.inertia": 1.0}
    run = drive.run(parameters, gains=(0.0, 0.0), tau_load=3.0)
    acceleration = 3.0 / (1.0 + 81 * 2e-4)
    assert run.signal("velocity")[-1] == pytest.approx(1.1 * acceleration, rel=1e-5)


def test_command_offset_is_added_below_the_logged_command(drive: Drive) -> None:
    pushed = drive.run(gains=(0.0, 0.0), tau_command_offset=4.0)
    asked = drive.run({"ctl.delay": 0.0}, gains=(0.0, 0.0), torque_reference=4.0)
    np.testing.assert_array_equal(pushed.signal("true_position"), asked.signal("true_position"))
    assert np.all(pushed.signal("torque_command") == 0.0)


@pytest.mark.parametrize("samples", [0, 1, 4, 32])
def test_the_command_is_late_by_whole_samples(drive: Drive, samples: int) -> None:
    """Row k + 1 shows what the sample at t_k, k = 100, asked for."""
    run = drive.run({"ctl.delay": samples}, gains=(50.0, 0.0))
    first = np.flatnonzero(np.abs(run.signal("torque_command")) > 40.0)[0]
    assert first == 101 + samples


def test_torque_command_stays_within_its_limit(drive: Drive) -> None:
    run = drive.run({"ctl.torque_limit": 22.0}, gains=(200.0, 2.0))
    assert np.abs(run.signal("torque_command")).max() == 22.0


def test_velocity_filter_is_exact_for_held_inputs(drive: Drive) -> None:
    """On a turning flywheel the command is -Kd w (1 - exp(-t / T)), a sample after the first."""
    spin = {"load.inertia": 1000.0, "friction.scale": 0.0, "initial.velocity": 2.0}
    run = drive.run({**IDEAL_ENCODERS, **spin, "ctl.delay": 0.0}, gains=(0.0, 0.1))
    samples = np.arange(60)
    expected = -0.2 * -np.expm1(-samples * 1e-3 / 8e-3)
    np.testing.assert_allclose(run.signal("torque_command")[1:61], expected, rtol=1e-4)


def test_readings_are_whole_counts_nearest_to_the_truth(drive: Drive) -> None:
    run = drive.run()
    for reading, truth, count in (
        ("position", "true_position", COUNT),
        ("motor_position", "true_motor_position", COUNT / 9.0),
    ):
        counts = run.signal(reading) / count
        np.testing.assert_allclose(counts, np.round(counts), atol=1e-8)
        assert np.abs(run.signal(reading) - run.signal(truth)).max() <= 0.5 * count * (1 + 1e-9)


def test_encoder_offset_moves_the_joint_the_other_way(drive: Drive) -> None:
    parameters = {**IDEAL_ENCODERS, **NO_RIPPLE, "friction.scale": 0.0}
    shifted = drive.run(parameters, duration=3.0, encoder_offset=0.01)
    straight = drive.run(parameters, duration=3.0)
    apart = shifted.signal("true_position")[-1] - straight.signal("true_position")[-1]
    assert apart == pytest.approx(-0.01, abs=1e-6)
    np.testing.assert_allclose(
        (shifted.signal("position") - shifted.signal("true_position"))[1:], 0.01, atol=1e-12
    )


def test_replaying_readings_through_the_sensor_ports_gives_the_recorded_command(
    drive: Drive,
) -> None:
    """Controller parity: a drive with another load, fed what this one read, asks for the same."""
    recorded = drive.run(duration=0.4)
    with (
        unpacked_fmu(models_folder() / "drive_twin.fmu") as folder,
        closing(FmuInstance(folder)) as other,
    ):
        other.start(load__inertia=0.25, friction__scale=0.5)
        joint_offset = motor_offset = 0.0
        commands = [other.get("torque_command")]
        for k in range(400):
            joint = other.get("position") - joint_offset
            motor = other.get("motor_position") - joint_offset - motor_offset
            joint_offset = recorded.signal("position")[k] - joint
            motor_offset = recorded.signal("motor_position")[k] - motor - joint_offset
            other.set(
                reference=recorded.signal("reference")[k],
                encoder_offset=joint_offset,
                motor_encoder_offset=motor_offset,
            )
            other.step(k * 1e-3, 1e-3)
            commands.append(other.get("torque_command"))
        assert abs(other.get("true_position") - recorded.signal("true_position")[-1]) > 0.01
    np.testing.assert_allclose(commands, recorded.signal("torque_command"), atol=1e-9)
