"""The exported FMU says of its variables what the original says, and is valid."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from fmpy import read_model_description
from fmpy.model_description import ModelDescription, ModelVariable
from fmpy.validation import validate_fmu

from gmfbo.sources.export.export import AugmentedFmu, PhysicsParameter, export_augmented
from gmfbo.sources.fmu_file.description import read_description
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.twin import FmuTwin
from tests.sources.conftest import AXIS, Repack, WriteTwin
from tests.sources.export.exported import CASES, export_case

PORTS = '[ports]\ntorque = "port.force"\n[states]\nvelocity = "velocity"\n'
COULOMB = PhysicsParameter("coulomb_friction.level", 20.0, "N", "Coulomb friction at the mass")

RICH = """
    <ScalarVariable name="time" valueReference="900" causality="independent"
                    variability="continuous"><Real /></ScalarVariable>
    <ScalarVariable name="position_again" valueReference="REFERENCE" causality="output"
                    description="&lt;&amp;&gt;"><Real declaredType="Length" /></ScalarVariable>
    <ScalarVariable name="mode" valueReference="901" causality="parameter" variability="fixed">
      <Enumeration declaredType="Mode" start="2" /></ScalarVariable>
    <ScalarVariable name="comment" valueReference="902" causality="parameter" variability="fixed">
      <String start="as delivered" /></ScalarVariable>
    <ScalarVariable name="map[1,1]" valueReference="903" causality="parameter"
                    variability="tunable"><Real start="0.5" /></ScalarVariable>
    <ScalarVariable name="map[1,2]" valueReference="904" causality="parameter"
                    variability="tunable"><Real start="1.5" /></ScalarVariable>
  </ModelVariables>"""
TYPES = """</UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Length"><Real quantity="Length" unit="m" min="-10" max="10" /></SimpleType>
    <SimpleType name="Mode"><Enumeration><Item name="a" value="1" /><Item name="b" value="2" />
    </Enumeration></SimpleType>
  </TypeDefinitions>"""


@pytest.fixture(scope="module")
def exports(tmp_path_factory: pytest.TempPathFactory) -> dict[str, AugmentedFmu]:
    folder = tmp_path_factory.mktemp("described")
    return {name: export_case(CASES[name], folder / name) for name in ("axis", "drive", "split")}


def _told(variable: ModelVariable) -> dict[str, object]:
    declared = variable.declaredType
    return {
        "type": variable.type,
        "causality": variable.causality,
        "variability": variable.variability,
        "initial": variable.initial,
        "description": variable.description,
        "unit": variable.unit or (declared and declared.unit),
        "displayUnit": variable.displayUnit,
        "quantity": variable.quantity or (declared and declared.quantity),
        "min": variable.min or (declared and declared.min),
        "max": variable.max or (declared and declared.max),
        "nominal": variable.nominal,
    }


def _units(description: ModelDescription) -> dict[str, str]:
    return {unit.name: repr(unit.baseUnit) for unit in description.unitDefinitions}


@pytest.mark.parametrize("name", ["axis", "drive", "split"])
def test_every_variable_keeps_what_the_original_says_of_it(
    name: str, exports: dict[str, AugmentedFmu]
) -> None:
    with FmuTwin(CASES[name].twin_file) as twin:
        prefixes, fmus = list(twin.file.fmus), twin.binding.fmus
    made = read_model_description(str(exports[name].fmu), validate=True)
    variables = {variable.name: variable for variable in made.modelVariables}
    values = CASES[name].parameters
    hidden = {"controller.position", "controller.motor_position"}  # only a wire drives them
    seen = set()
    for prefix, fmu in zip(prefixes or [""], fmus, strict=True):
        original = read_model_description(str(fmu.path))
        assert _units(original).items() <= _units(made).items()
        for variable in original.modelVariables:
            full = f"{prefix}.{variable.name}" if prefix else variable.name
            if full in hidden:
                assert full not in variables
                continue
            seen.add(full)
            assert _told(variables[full]) == _told(variable)
            if full in values:
                assert float(variables[full].start) == values[full]
            else:
                assert variables[full].start == variable.start
    physics = {f"physics.{parameter}" for parameter in CASES[name].physics}
    assert variables.keys() == seen | physics


@pytest.mark.parametrize("name", ["axis", "drive", "split"])
def test_it_passes_fmpys_validation(name: str, exports: dict[str, AugmentedFmu]) -> None:
    assert validate_fmu(str(exports[name].fmu)) == []
    made = read_model_description(str(exports[name].fmu), validate=True)
    assert made.defaultExperiment.stepSize == "0.001"
    assert "Internal step 0.0001 s" in made.description
    assert exports[name].platforms == ("linux64", "win64", "darwin64")
    assert exports[name].step == 1e-4


def test_author_licence_and_model_name_stay_the_originals(exports: dict[str, AugmentedFmu]) -> None:
    made = read_model_description(str(exports["axis"].fmu))
    original = read_model_description(str(models_folder() / "linear_axis.fmu"))
    assert (made.author, made.license) == (original.author, original.license)
    assert (made.modelName, made.fmiVersion) == ("linear_axis", "2.0")
    assert made.generationDateAndTime == original.generationDateAndTime
    assert made.guid != original.guid


def test_physics_parameters_have_unit_description_and_value(
    write_twin: WriteTwin, tmp_path: Path
) -> None:
    torque = PhysicsParameter("viscous_friction.coefficient", 0.5, "mN.m.s/deg", "in odd units")
    with FmuTwin(write_twin(AXIS + PORTS)) as twin:
        made = export_augmented(
            twin, tmp_path, parameters={}, physics=[COULOMB, torque], settings={}, substeps=2
        )
    assert validate_fmu(str(made.fmu)) == []
    level = read_description(made.fmu).variables["physics.coulomb_friction.level"]
    assert (level.start, level.unit, level.description) == (20.0, "N", COULOMB.description)
    assert level.tunable
    odd = read_description(made.fmu).variables["physics.viscous_friction.coefficient"]
    assert odd.to_si == pytest.approx(1e-3 * 180.0 / 3.141592653589793)
    units = {u.name: u for u in read_model_description(str(made.fmu)).unitDefinitions}
    assert units["mN.m.s/deg"].baseUnit.rad == -1


def test_types_texts_aliases_and_the_time_are_carried_over(
    write_twin: WriteTwin, repack: Repack, tmp_path: Path
) -> None:
    axis = read_description(models_folder() / "linear_axis.fmu")
    rich = RICH.replace("REFERENCE", str(axis.variables["position"].reference))
    edits = {"</ModelVariables>": rich, "</UnitDefinitions>": TYPES}
    fmu = repack(edits=edits, members={"documentation/index.html": b"<p>as delivered</p>"})
    folder = tmp_path / "out"
    folder.mkdir()
    with FmuTwin(write_twin(AXIS + PORTS, fmu)) as twin:
        made = export_augmented(
            twin, folder, parameters={}, physics=[COULOMB], settings={}, substeps=1
        )
    assert validate_fmu(str(made.fmu)) == []
    original, copy = (
        {v.name: v for v in read_model_description(str(path)).modelVariables}
        for path in (fmu, made.fmu)
    )
    assert copy.keys() == original.keys() | {"physics.coulomb_friction.level"}
    for name, variable in original.items():
        assert _told(copy[name]) == _told(variable)
        assert copy[name].start == variable.start
    assert copy["position_again"].valueReference == copy["position"].valueReference
    assert [item.name for item in copy["mode"].declaredType.items] == ["a", "b"]
    with zipfile.ZipFile(made.fmu) as archive:
        assert archive.read("documentation/index.html") == b"<p>as delivered</p>"
        assert b"Redistribution" in archive.read(
            "documentation/licenses/fmu_manipulation_toolbox.txt"
        )


def test_two_exports_are_the_same_bytes_and_another_value_another_guid(tmp_path: Path) -> None:
    first, second = (export_case(CASES["axis"], tmp_path / name) for name in ("one", "a second"))
    assert first.fmu.read_bytes() == second.fmu.read_bytes()
    assert first.twin_file.read_bytes() == second.twin_file.read_bytes()
    third = export_case(CASES["axis"], tmp_path / "third", physics=[COULOMB, COULOMB][:1])
    other = PhysicsParameter("coulomb_friction.level", 21.0, "N", COULOMB.description)
    fourth = export_case(CASES["axis"], tmp_path / "fourth", physics=[other])
    assert read_description(third.fmu).guid != read_description(fourth.fmu).guid


LOOP = """
name = "loop"
step = 1e-3
[fmus]
controller = { kind = "pd_filtered", sample_time = 1e-3, kp = 500.0 }
plant = "FMU"
[wires]
"controller.measured" = "plant.true_position"
"plant.port.force" = "controller.u"
[inputs]
reference = "controller.reference"
[outputs]
position = "plant.true_position"
[ports]
torque = "plant.port.force"
[states]
velocity = "plant.velocity"
"""


def test_it_begins_at_the_start_time_of_the_twins_fmu(
    write_twin: WriteTwin, repack: Repack, tmp_path: Path
) -> None:
    """The first FMU is a controller of gmfbo, whose start time is 0."""
    late = repack(edits={'startTime="0"': 'startTime="2.5"'})
    with FmuTwin(write_twin(LOOP, late)) as twin:
        made = export_augmented(
            twin, tmp_path, parameters={}, physics=[COULOMB], settings={}, substeps=2
        )
        assert twin.binding.default_start == 2.5
    assert read_description(made.fmu).default_start == 2.5
    assert validate_fmu(str(made.fmu)) == []
