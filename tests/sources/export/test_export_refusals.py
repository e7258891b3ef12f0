"""One line that says why a twin cannot be exported, and what an export lacks."""

from __future__ import annotations

import dataclasses
import zipfile
from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import ExportError, InputError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.export.export import AugmentedFmu, PhysicsParameter, export_augmented
from gmfbo.sources.export.exportable import common_platforms
from gmfbo.sources.fmu_file.description import read_description
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.twin import FmuTwin
from tests.sources.conftest import AXIS, FAULTY, LOOP, TEST_FMUS, Repack, WriteTwin

PORTS = '[ports]\ntorque = "port.force"\n'
LEVEL = PhysicsParameter("coulomb_friction.level", 1.0, "N", "level")
LIBRARY = "binaries/linux64/linear_axis.so"
FLAG = 'canBeInstantiatedOnlyOncePerProcess="'


def export(
    path: Path,
    folder: Path,
    *,
    physics: tuple[PhysicsParameter, ...] = (),
    settings: dict[str, float] | None = None,
    substeps: int = 1,
    **parameters: float,
) -> AugmentedFmu:
    folder.mkdir(exist_ok=True)
    with FmuTwin(path) as twin:
        return export_augmented(
            twin,
            folder,
            parameters=parameters,
            physics=physics,
            settings=settings or {},
            substeps=substeps,
        )


def test_an_fmu_that_needs_its_tool_is_refused(
    write_twin: WriteTwin, repack: Repack, tmp_path: Path
) -> None:
    fmu = repack(edits={FLAG: f'needsExecutionTool="true" {FLAG}'})
    with pytest.raises(ExportError, match=r"'repacked\.fmu' needs the tool that made it"):
        export(write_twin(AXIS, fmu), tmp_path / "out")


def test_an_fmu_of_one_instance_a_process_is_exported_as_such(
    write_twin: WriteTwin, repack: Repack, tmp_path: Path
) -> None:
    fmu = repack(edits={f'{FLAG}false"': f'{FLAG}true"'})
    made = export(write_twin(AXIS + PORTS, fmu), tmp_path / "out", physics=(LEVEL,))
    assert read_description(made.fmu).capabilities["canBeInstantiatedOnlyOncePerProcess"] is True


def test_an_fmu_of_one_instance_a_process_cannot_be_in_a_twin_twice(
    write_twin: WriteTwin, repack: Repack, tmp_path: Path
) -> None:
    fmu = repack(edits={f'{FLAG}false"': f'{FLAG}true"'})
    text = (
        f'name = "two"\nstep = 1e-3\n[fmus]\na = "{fmu}"\nb = "{fmu}"\n'
        '[outputs]\nposition = "a.position"\n'
    )
    with pytest.raises(ExportError, match="is in the twin twice and can be instantiated only once"):
        export(write_twin(text), tmp_path / "out")


def test_two_ports_cannot_be_one_input(write_twin: WriteTwin, tmp_path: Path) -> None:
    text = AXIS + PORTS + 'command = "port.force"\n'
    with pytest.raises(ExportError, match=r"ports 'torque' and 'command' are both 'port\.force'"):
        export(write_twin(text), tmp_path / "out", physics=(LEVEL,))


def test_physics_needs_a_port(axis: Path, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=r"no port for 'coulomb_friction\.level'"):
        export(axis, tmp_path / "out", physics=(LEVEL,))


def test_unknown_names_and_values_out_of_bounds_are_refused(
    write_twin: WriteTwin, tmp_path: Path
) -> None:
    path, out = write_twin(AXIS + PORTS), tmp_path / "out"
    wrong = dataclasses.replace(LEVEL, name="coulomb_friction.levle")
    with pytest.raises(InputError, match=r"did you mean 'coulomb_friction\.level'"):
        export(path, out, physics=(wrong,))
    with pytest.raises(InputError, match=r"no parameter 'settings\.lateness'"):
        export(path, out, settings={"settings.lateness": 1.0})
    with pytest.raises(InputError, match="no FMU parameter 'maas'; did you mean 'mass'"):
        export(path, out, maas=1.0)
    with pytest.raises(InputError, match="parameter 'mass': expected a value within"):
        export(path, out, mass=-1.0)
    with pytest.raises(InputError, match="substeps: expected 1 or more, got 0"):
        export(path, out, substeps=0)
    assert list(out.iterdir()) == []


def test_an_export_that_does_not_run_is_not_left_behind(
    write_twin: WriteTwin, tmp_path: Path
) -> None:
    """Fault 6 at stage 1 refuses the instance."""
    out = tmp_path / "out"
    with pytest.raises(ExportError, match="the augmented FMU does not run, though its parts do"):
        export(write_twin(FAULTY, TEST_FMUS / "faulty.fmu"), out, fault=6, stage=1)
    assert list(out.iterdir()) == []


def test_a_folder_that_is_none_is_said(axis: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ExportError, match=r"cannot write into '.*file'"), FmuTwin(axis) as twin:
        export_augmented(
            twin, tmp_path / "file", parameters={}, physics=[], settings={}, substeps=1
        )


def test_platforms_are_those_of_all_fmus(repack: Repack) -> None:
    physics = read_description(models_folder() / "physics.fmu")
    others = {
        "binaries/win64/linear_axis.dll": "win.dll",
        "binaries/darwin64/linear_axis.dylib": "mac.dylib",
    }
    linux = repack(rename=others)
    (only,) = common_platforms([read_description(linux), physics])
    assert only.name == "linux-x86_64"
    foreign = repack(rename={**others, LIBRARY: "binaries/linux32/linear_axis.so"})
    with pytest.raises(ExportError, match=r"'repacked\.fmu' has .*linux32.*'physics\.fmu' has"):
        common_platforms([read_description(foreign), physics])


def test_a_library_for_intel_macs_is_not_taken_for_one_for_arm(repack: Repack) -> None:
    dylib = "binaries/darwin64/linear_axis.dylib"
    intel = bytes.fromhex("cffaedfe07000001") + bytes(100)
    arm = bytes.fromhex("cffaedfe0c000001") + bytes(100)
    names = [
        {p.name for p in common_platforms([read_description(repack(members={dylib: library}))])}
        for library in (intel, arm)
    ]
    assert "macos-aarch64" not in names[0]
    assert "macos-aarch64" in names[1]


@pytest.mark.parametrize("name", ["binaries/linux64/other.so", "binaries/x86_64-linux/axis2.so"])
def test_a_library_of_another_name_or_folder_is_found(
    name: str, write_twin: WriteTwin, repack: Repack, tmp_path: Path
) -> None:
    made = export(write_twin(AXIS, repack(rename={LIBRARY: name})), tmp_path / "out")
    assert "linux64" in made.platforms
    with zipfile.ZipFile(made.fmu) as archive:
        assert f"resources/00/{LIBRARY}" in archive.namelist()


def test_what_is_lost_is_told(axis: Path, tmp_path: Path) -> None:
    made = export(axis, tmp_path / "out")
    assert made.dropped == (
        "saving and restoring its state (canGetAndSetFMUstate)",
        "binaries for aarch64-linux",
        "Linux systems with a glibc older than 2.34",
    )


def test_units_that_mean_two_things_are_told(
    write_twin: WriteTwin, repack: Repack, tmp_path: Path
) -> None:
    odd = repack(edits={r'<Unit name="N">\s*<BaseUnit kg="1"': '<Unit name="N"><BaseUnit kg="2"'})
    axis = models_folder() / "linear_axis.fmu"
    text = (
        f'name = "two"\nstep = 1e-3\n[fmus]\na = "{odd}"\nb = "{axis}"\n'
        '[wires]\n"b.reference" = "a.position"\n[outputs]\nposition = "b.position"\n'
    )
    made = export(write_twin(text), tmp_path / "out")
    assert made.dropped[-2:] == (
        "inputs that a wire inside drives: b.reference",
        "one of the meanings that its FMUs give to the unit 'N': the first is written",
    )


def test_a_controller_of_the_projects_own_goes_into_the_export(
    write_twin: WriteTwin, tmp_path: Path
) -> None:
    ports = '[ports]\ntorque = "plant.port.force"\n[states]\nvelocity = "plant.velocity"\n'
    path = write_twin(LOOP.replace("[inputs]", ports + "[inputs]", 1))
    time = np.arange(301, dtype=np.float64) * 1e-3
    recording = Recording(time=time, signals={"reference": 0.01 * np.sin(20.0 * time)})
    made = export(path, tmp_path / "out", physics=(dataclasses.replace(LEVEL, value=0.0),))
    with FmuTwin(path, isolated=False) as twin:
        expected = twin.run({}, recording)
    with FmuTwin(made.twin_file, isolated=False) as twin:
        trajectory = twin.run({}, recording)
        assert twin.binding.nominal("controller.kp") == 500.0
    assert np.array_equal(trajectory.signal("force"), expected.signal("force"))
    assert np.abs(trajectory.signal("position")).max() > 1e-4
