"""The exported FMU does what was diagnosed, to the bit, and nothing when its physics is off."""

from __future__ import annotations

import re
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording
from gmfbo.sources.export.export import AugmentedFmu, export_augmented
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.twin import FmuTwin
from tests.sources.export.exported import (
    CASES,
    STEPS,
    SUBSTEPS,
    Case,
    diagnosed,
    excitation,
    export_case,
    named,
)

Exports = dict[str, AugmentedFmu]


@pytest.fixture(scope="module")
def exports(tmp_path_factory: pytest.TempPathFactory) -> Exports:
    folder = tmp_path_factory.mktemp("exports")
    return {name: export_case(case, folder / name) for name, case in CASES.items()}


@pytest.mark.parametrize("name", CASES)
def test_the_exported_fmu_gives_the_diagnosed_trajectories(name: str, exports: Exports) -> None:
    recording = excitation(CASES[name])
    expected = diagnosed(CASES[name], recording)
    assert expected.outcome.status == "ok"
    with FmuTwin(exports[name].twin_file, isolated=False) as twin:
        trajectory = twin.run({}, recording)
        outputs = list(twin.file.outputs)
    assert trajectory.status == "ok"
    for output in outputs:
        moved = np.ptp(trajectory.signal(output))
        assert moved > 0.0
        error = np.abs(trajectory.signal(output) - expected.held[output]).max()
        assert error <= 1e-12 * moved


@pytest.mark.parametrize("name", CASES)
def test_physics_changes_what_the_twin_does(name: str, exports: Exports) -> None:
    case, recording = CASES[name], excitation(CASES[name])
    with FmuTwin(exports[name].twin_file, isolated=False) as twin:
        augmented = twin.run({}, recording).signal("position")
    with FmuTwin(case.twin_file, isolated=False, parameters=case.parameters) as twin:
        without = twin.run({}, recording).signal("position")
    assert np.abs(augmented - without).max() > 1e-3 * np.ptp(without)


@pytest.mark.parametrize("name", CASES)
def test_physics_switched_off_from_outside_leaves_the_twin_to_the_bit(
    name: str, exports: Exports
) -> None:
    case, recording = CASES[name], excitation(CASES[name])
    # A wavenumber or a width in place of zero has no meaning; sizes are what switches off.
    off = {f"physics.{p}": 0.0 for p in case.physics if "wavenumber" not in p}
    with FmuTwin(exports[name].twin_file, isolated=False) as twin:
        trajectory = twin.run({}, recording, parameters=off)
        step, outputs = twin.step, list(twin.file.outputs)
    with FmuTwin(
        case.twin_file, isolated=False, parameters=case.parameters, step=step / SUBSTEPS
    ) as twin:
        original = twin.run({}, recording)
    for output in outputs:
        expected = original.signal(output)[::SUBSTEPS]
        assert np.array_equal(trajectory.signal(output), expected)


@pytest.mark.parametrize(
    ("name", "port", "size"),
    [
        ("axis", "torque", 5.0),
        ("axis", "command", 0.1),
        ("servo", "sensor", 1e-3),
        ("bench", "torque", 0.01),
        ("drive", "command", 0.5),
        ("split", "torque", 0.5),
        ("split", "command", 0.5),  # on a wire, which the user's input adds to
        ("split", "sensor", 2e-3),
    ],
)
def test_the_users_own_input_to_a_port_adds(
    name: str, port: str, size: float, exports: Exports, tmp_path: Path
) -> None:
    case = CASES[name]
    recording = excitation(case)
    pushed = size * np.sign(np.sin(2.0 * np.pi * 7.0 * recording.time))
    expected = diagnosed(case, recording, at_ports={port: pushed})
    text = exports[name].twin_file.read_text()
    ports = re.search(r"\[ports\]\n(?:.*\n)*?" + port + r' = "(.*)"', text)
    assert ports
    text = text.replace("[inputs]\n", f'[inputs]\npush = "{ports[1]}"\n')
    text = text.replace("augmented.fmu", str(exports[name].fmu))
    (tmp_path / "pushed.toml").write_text(text)
    both = recording.with_signals({"push": pushed})
    with FmuTwin(tmp_path / "pushed.toml", isolated=False) as twin:
        position = twin.run({}, both).signal("position")
    unpushed = diagnosed(case, recording).held["position"]
    assert np.abs(position - unpushed).max() > 1e-4 * np.ptp(unpushed)
    assert np.abs(position - expected.held["position"]).max() <= 1e-12 * np.ptp(position)


def test_the_exported_fmu_is_two_fmus_stepped_by_hand(exports: Exports, tmp_path: Path) -> None:
    """The reference here is a loop over fmpy's slaves, with nothing of gmfbo in it."""
    case = CASES["axis"]
    reference = excitation(case).signal("reference")
    expected = _by_hand(reference, case, tmp_path)
    column = np.zeros(STEPS, dtype=[("time", float), ("reference", float)])
    column["time"], column["reference"] = np.arange(STEPS) * 1e-3, reference[:-1]
    result = fmpy.simulate_fmu(
        str(exports["axis"].fmu),
        stop_time=STEPS * 1e-3,
        output_interval=1e-3,
        input=column,
        output=["position"],
    )
    assert np.array_equal(result["position"], expected)


def _by_hand(reference: NDArray[np.float64], case: Case, folder: Path) -> NDArray[np.float64]:
    step = 1e-3 / SUBSTEPS
    slaves, references = [], []
    for name in ("physics", "linear_axis"):
        path = str(models_folder() / f"{name}.fmu")
        description = fmpy.read_model_description(path)
        slave = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=fmpy.extract(path, str(folder / name)),
        )
        slave.instantiate()
        slaves.append(slave)
        references.append({v.name: v.valueReference for v in description.modelVariables})
    (physics, axis), (p, a) = slaves, references
    values = {**case.physics, "settings.command_lateness": step}
    physics.setReal([p[name] for name in values], list(values.values()))
    axis.setReal([a["mass"]], [case.parameters["mass"]])
    for slave in slaves:
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
    states = {"position": "true_position", "velocity": "velocity", "command": "drive_voltage"}
    ports = {"torque": "port.force", "command": "port.command", "sensor": "port.sensor"}
    positions = axis.getReal([a["position"]])
    for k in range((reference.size - 1) * SUBSTEPS):
        seen = axis.getReal([a[output] for output in states.values()])
        physics.setReal([p[f"state.{state}"] for state in states], seen)
        physics.doStep(k * step, step)
        added = physics.getReal([p[output] for output in ports])
        axis.setReal([a[port] for port in ports.values()], added)
        axis.setReal([a["reference"]], [reference[k // SUBSTEPS]])
        axis.doStep(k * step, step)
        if (k + 1) % SUBSTEPS == 0:
            positions += axis.getReal([a["position"]])
    for slave in slaves:
        slave.terminate()
        slave.freeInstance()
    return np.array(positions)


def test_start_values_are_in_force_and_not_only_written(exports: Exports) -> None:
    case, recording = CASES["axis"], excitation(CASES["axis"])
    explicit = {**case.parameters, **{f"physics.{k}": v for k, v in case.physics.items()}}
    with FmuTwin(exports["axis"].twin_file, isolated=False) as twin:
        default = twin.run({}, recording).signal("position")
        same = twin.run({}, recording, parameters=explicit).signal("position")
        other = twin.run({}, recording, parameters={**explicit, "mass": 95.1089})
    assert np.array_equal(default, same)
    assert not np.array_equal(default, other.signal("position"))


@pytest.mark.parametrize("substeps", [1, 3])
def test_any_number_of_substeps_is_exact(substeps: int, tmp_path: Path) -> None:
    case, recording = CASES["servo"], excitation(CASES["servo"])
    made = export_case(case, tmp_path, substeps=substeps)
    assert made.step == 1e-3 / substeps
    expected = diagnosed(case, recording, substeps=substeps).held["position"]
    with FmuTwin(made.twin_file, isolated=False) as twin:
        position = twin.run({}, recording).signal("position")
    assert np.abs(position - expected).max() <= 1e-12 * np.ptp(expected)


def test_a_long_run_loses_no_internal_step(exports: Exports) -> None:
    case = CASES["axis"]
    swept = excitation(case, 30_000)
    later = Recording(time=swept.time + 1000.0, signals=swept.signals)
    expected = diagnosed(case, later).held["position"]
    with FmuTwin(exports["axis"].twin_file, isolated=False) as twin:
        position = twin.run({}, later).signal("position")
    assert np.array_equal(position, expected)


def test_a_twin_without_ports_is_exported_with_its_refitted_parameters(tmp_path: Path) -> None:
    lines = CASES["axis"].twin_file.read_text().splitlines()
    first = lines.index("[ports]")
    last = lines.index("[roles]")
    fmu = models_folder() / "linear_axis.fmu"
    text = "\n".join(lines[:first] + lines[last:]).replace("linear_axis.fmu", str(fmu))
    (tmp_path / "portless.toml").write_text(text)
    recording = excitation(CASES["axis"])
    with FmuTwin(tmp_path / "portless.toml", isolated=False) as twin:
        made = export_augmented(
            twin, tmp_path, parameters={"mass": 70.0}, physics=[], settings={}, substeps=1
        )
        expected = twin.run({}, recording, parameters={"mass": 70.0})
    with FmuTwin(made.twin_file, isolated=False) as twin:
        trajectory = twin.run({}, recording)
        assert not any("physics" in name for name in twin.binding.variables)
    assert np.array_equal(trajectory.signal("position"), expected.signal("position"))


def test_an_augmented_twin_can_be_augmented_again(exports: Exports, tmp_path: Path) -> None:
    recording = excitation(CASES["axis"])
    with FmuTwin(exports["axis"].twin_file, isolated=False) as twin:
        made = export_augmented(
            twin,
            tmp_path,
            parameters={"physics.coulomb_friction.level": 12.0},
            physics=named({"viscous_friction.coefficient": 100.0}),
            settings={},
            substeps=SUBSTEPS,
        )
    both = {"coulomb_friction.level": 12.0, "viscous_friction.coefficient": 100.0}
    expected = diagnosed(Case("linear_axis", both, {"mass": 80.0}), recording)
    with FmuTwin(made.twin_file, isolated=False) as twin:
        position = twin.run({}, recording).signal("position")
        assert "physics_.viscous_friction.coefficient" in twin.binding.parameters
    np.testing.assert_allclose(position, expected.held["position"], rtol=0.0, atol=1e-9)
