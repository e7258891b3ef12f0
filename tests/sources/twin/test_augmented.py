"""A twin with physics at its ports: off it is the twin, on it is what the equations say."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin, RunPlan
from gmfbo.sources.twin.response import Response
from gmfbo.sources.worker.isolation import Isolated
from tests.diagnosis.servo_recordings import rewritten

GAINS = {"kp": 40.0, "kd": 0.8}
STEP = 1e-3


def twin_of(model: str, **options: float) -> FmuTwin:
    return FmuTwin(models_folder() / f"{model}.toml", isolated=False, **options)  # type: ignore[arg-type]


def asked(reference: NDArray[np.float64], parameters: Mapping[str, float] = GAINS) -> Recording:
    time = np.arange(reference.size, dtype=np.float64) * STEP
    return Recording(
        time=time, signals={"reference": reference}, name="a.csv", parameters=parameters
    )


def sway(count: int = 400) -> NDArray[np.float64]:
    t = np.arange(count) * STEP
    swayed: NDArray[np.float64] = 0.3 * np.sin(2.0 * np.pi * 3.0 * t) ** 2
    return swayed


@pytest.fixture(scope="module")
def servo() -> Iterator[AugmentedTwin]:
    with AugmentedTwin(twin_of("servo_axis"), isolated=False) as simulator:
        yield simulator


def respond(
    simulator: AugmentedTwin,
    recording: Recording,
    physics: Mapping[str, float] | None = None,
    **driven: Mapping[str, NDArray[np.float64]],
) -> Response:
    run = simulator.run(simulator.plan(recording, {}), {}, physics, **driven)  # type: ignore[arg-type]
    assert run.outcome.status == "ok", run.outcome.message
    return run


def test_what_drives_a_wired_command_port_is_the_command_where_none_is_stated(
    tmp_path: Path,
) -> None:
    text = (models_folder() / "drive_split.toml").read_text(encoding="utf-8")
    stated = 'command = "controller.torque_command"\n'
    assert text.count(stated) == 1
    for name in ("drive_controller.fmu", "drive_plant.fmu"):
        text = text.replace(f'"{name}"', f'"{(models_folder() / name).as_posix()}"')
    recording = asked(sway(), {"controller.ctl.Kp": 100.0, "controller.ctl.Kd": 6.0})
    seen = []
    for number, own in enumerate((text, text.replace(stated, ""))):
        path = tmp_path / f"{number}.toml"
        path.write_text(own, encoding="utf-8")
        with AugmentedTwin(FmuTwin(path, isolated=False), isolated=False) as simulator:
            seen.append(respond(simulator, recording, {"transport_delay.delay": 3e-3}))
    for name, column in seen[0].held.items():
        np.testing.assert_array_equal(seen[1].held[name], column)


@pytest.mark.parametrize(
    ("model", "parameters"),
    [
        ("servo_axis", GAINS),
        ("drive_split", {"controller.ctl.Kp": 100.0, "controller.ctl.Kd": 6.0}),
    ],
)
def test_without_physics_it_is_the_twin_to_the_last_bit(
    model: str, parameters: Mapping[str, float]
) -> None:
    """The twin steps at 0.1 ms by itself, held inputs and all, and is read every millisecond."""
    recording = asked(sway(), parameters)
    with AugmentedTwin(twin_of(model), substeps=10, isolated=False) as simulator:
        plan = simulator.plan(recording, {})
        run = simulator.run(plan, {})
    fine = np.repeat(recording.signals["reference"], 10)[:-9]
    time = np.arange(fine.size, dtype=np.float64) * np.float64(STEP / 10)
    held = Recording(time=time, signals={"reference": fine}, name="a.csv", parameters=parameters)
    with twin_of(model, step=STEP / 10) as twin:
        alone = twin.run({}, held)
    assert alone.status == run.outcome.status == "ok"
    for name, values in run.held.items():
        np.testing.assert_array_equal(values, alone.signal(name)[::10], err_msg=name)


def test_an_effect_of_no_size_changes_no_bit(servo: AugmentedTwin) -> None:
    recording = asked(sway())
    plain, off = respond(servo, recording), respond(servo, recording, {"gravity_torque.sine": 0.0})
    for name, values in plain.held.items():
        np.testing.assert_array_equal(values, off.held[name])


def test_a_constant_torque_moves_a_resting_loop_by_its_level_over_kp(servo: AugmentedTwin) -> None:
    level = 0.4
    run = respond(servo, asked(np.zeros(1500)), {"constant_torque_offset.level": level})
    assert run.held["position"][-1] == pytest.approx(level / GAINS["kp"], rel=1e-6)
    assert run.held["torque_command"][-1] == pytest.approx(-level, rel=1e-6)
    np.testing.assert_array_equal(run.ports["torque"], level)


def test_a_plan_after_a_lead_begins_where_a_constant_torque_has_brought_the_loop(
    servo: AugmentedTwin,
) -> None:
    level, recording = 0.4, asked(np.zeros(20))
    plan = servo.plan(recording, GAINS)
    held = RunPlan.after(recording, plan.experiment, 1500, plan.substeps)
    run = servo.run(held, GAINS, {"constant_torque_offset.level": level})
    np.testing.assert_allclose(run.held["position"], level / GAINS["kp"], rtol=1e-6)
    np.testing.assert_allclose(run.held["torque_command"], -level, rtol=1e-6)


def test_a_sensor_offset_moves_the_shaft_the_other_way(servo: AugmentedTwin) -> None:
    run = respond(servo, asked(np.zeros(1500)), {"sensor_offset.level": 0.01})
    assert run.states["position"][-1] == pytest.approx(-0.01, rel=1e-6)
    assert run.held["position"][-1] == pytest.approx(0.0, abs=1e-8)


def test_viscous_friction_at_the_port_is_that_of_the_twin(servo: AugmentedTwin) -> None:
    """The port holds the torque over a step of 0.1 ms: a lag of half of it is what remains."""
    recording = asked(sway())
    plan = servo.plan(recording, {})
    at_port = servo.run(plan, {"viscous": 0.05}, {"viscous_friction.coefficient": 0.03})
    inside = servo.run(plan, {"viscous": 0.08})
    difference = at_port.held["position"] - inside.held["position"]
    without = servo.run(plan, {"viscous": 0.05}).held["position"] - inside.held["position"]
    assert np.abs(difference).max() < 0.01 * np.abs(without).max()


def test_a_torque_at_the_port_adds_to_the_physics_there(servo: AugmentedTwin) -> None:
    recording, level = asked(np.zeros(800)), 0.2
    pushed = respond(servo, recording, excitation={"torque": np.full(800, level)})
    offset = respond(servo, recording, {"constant_torque_offset.level": level})
    np.testing.assert_array_equal(pushed.held["position"], offset.held["position"])


def test_an_excitation_acts_from_its_row_on_and_no_earlier(servo: AugmentedTwin) -> None:
    push = np.zeros(100)
    push[50:] = 0.5
    run = respond(servo, asked(np.zeros(100)), excitation={"torque": push})
    assert np.all(run.held["position"][:51] == 0.0)
    assert run.held["position"][51] > 0.0
    np.testing.assert_array_equal(run.ports["torque"][:-1], push[:-1])


def test_inputs_are_held_over_the_substeps_of_a_communication_step() -> None:
    plans = []
    for substeps in (1, 4):
        with AugmentedTwin(twin_of("servo_axis"), substeps=substeps, isolated=False) as simulator:
            plans.append(simulator.plan(asked(sway(50)), {}))
    coarse, fine = plans
    np.testing.assert_array_equal(fine.inputs, np.repeat(coarse.inputs, 4, axis=0))
    assert fine.lead == coarse.lead


def test_the_new_command_is_the_held_one_of_the_next_row(servo: AugmentedTwin) -> None:
    run = respond(servo, asked(sway()))
    np.testing.assert_array_equal(run.new["torque_command"][:-1], run.held["torque_command"][1:])


def test_a_twin_that_has_to_settle_does_so_under_the_first_row(tmp_path: Path) -> None:
    start = np.full(300, 0.2)
    unknown = {'"initial_position" = 0.0 ': "# "}
    twin = rewritten("servo_axis", tmp_path, unknown)
    with AugmentedTwin(twin, isolated=False) as simulator:
        plan = simulator.plan(asked(start), {})
        run = simulator.run(plan, {})
    assert plan.lead > 0
    assert plan.inputs.shape[0] == (plan.lead + 299) * simulator.substeps
    np.testing.assert_allclose(run.held["position"], 0.2, rtol=1e-3)
    assert run.held["position"].shape == (300,)


def test_physics_stands_before_the_fmu_that_owns_each_port_of_a_wired_twin() -> None:
    with AugmentedTwin(twin_of("drive_split"), isolated=False) as simulator:
        instances = simulator._augmented.physics
        names = [fmu.model_name for fmu in simulator._augmented.binding.fmus]
    assert len(names) == 4
    assert sorted(port for i in instances for port in i.ports) == ["command", "sensor", "torque"]
    assert [i.index for i in instances] == [0, 2]
    assert names[0] == names[2]


@pytest.mark.parametrize("loss", [0.1, 0.3])
def test_on_wires_a_gain_loss_is_exactly_the_smaller_command(loss: float) -> None:
    """Physics on the wire sees the command of its own step, so that loss scales what arrives."""
    parameters = {"controller.ctl.Kp": 100.0, "controller.ctl.Kd": 6.0}
    with AugmentedTwin(twin_of("drive_split"), isolated=False) as simulator:
        plan = simulator.plan(asked(0.1 * sway(), parameters), {})
        run = simulator.run(plan, {}, {"actuator_gain_loss.loss": loss})
    np.testing.assert_allclose(
        run.ports["command"][:-1], -loss * run.new["torque_command"][:-1], rtol=1e-12
    )


def test_a_tracking_loop_needs_no_effort_where_the_twin_is_right() -> None:
    time = np.arange(800, dtype=np.float64) * STEP
    current = 1.5 * np.sin(2.0 * np.pi * 1.5 * time)
    recording = Recording(time=time, signals={"current": current}, name="bench.csv")
    inertia, speed = 0.005, 90.0
    loop = {"tracking.kp": inertia * speed**2, "tracking.kd": 1.6 * inertia * speed}
    with AugmentedTwin(twin_of("motor_bench"), isolated=False) as bench:
        plan = bench.plan(recording, {})
        free = bench.run(plan, {"inertia": inertia})
        held = bench.run(plan, {"inertia": inertia}, loop, measured=free.states["position"])
        wrong = bench.run(plan, {"inertia": 0.006}, loop, measured=free.states["position"])
    acceleration = np.gradient(free.states["velocity"], time)
    assert np.abs(held.effort[20:-20]).max() < 1e-3 * inertia * np.abs(acceleration).max()
    share = wrong.effort @ acceleration / (acceleration @ acceleration)
    assert share == pytest.approx(0.001, rel=0.1)


def test_a_worker_gives_the_bits_of_a_run_in_process(servo: AugmentedTwin) -> None:
    recording, physics = asked(sway()), {"coulomb_friction.level": 0.2}
    own = respond(servo, recording, {**physics, "coulomb_friction.deflection": 1e-6})
    with AugmentedTwin(twin_of("servo_axis")) as worker:
        plan = worker.plan(recording, {})
        other = worker.run(plan, {}, {**physics, "coulomb_friction.deflection": 1e-6})
    for name, values in own.held.items():
        np.testing.assert_array_equal(values, other.held[name])


def test_a_kept_worker_goes_on_with_the_next_and_ends_with_the_block(
    servo: AugmentedTwin,
) -> None:
    recording = asked(sway())
    own = respond(servo, recording, {"coulomb_friction.level": 0.2})
    twin = twin_of("servo_axis")
    with twin.keeping_workers():
        assert twin.kept is not None
        for substeps in (3, 10):
            with AugmentedTwin(twin, substeps=substeps) as first:
                respond(first, recording)
            assert len(twin.kept) == 1
        kept = twin.kept
        certain = twin.with_uncertain({})
        with AugmentedTwin(certain) as second:
            other = respond(second, recording, {"coulomb_friction.level": 0.2})
            assert kept.take() is None
        worker = kept.take()
        assert isinstance(worker, Isolated)
        kept.give(worker)
        assert worker._work.exists()
    assert twin.kept is None
    assert not worker._work.exists()
    for name, values in own.held.items():
        np.testing.assert_array_equal(values, other.held[name])
