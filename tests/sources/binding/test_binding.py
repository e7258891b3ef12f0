"""A twin file against its FMU: every name has to be there and to fit its part."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from gmfbo import FmuTwin
from gmfbo.errors import FmuFileError, InputError, TwinFileError
from tests.sources.conftest import AXIS, FAULTY, LOOP, TEST_FMUS

if TYPE_CHECKING:
    from tests.sources.conftest import Repack, WriteTwin


FMI_1 = """<?xml version="1.0"?>
<fmiModelDescription fmiVersion="1.0" modelName="m" modelIdentifier="m" guid="g"
  numberOfContinuousStates="0" numberOfEventIndicators="0">
  <ModelVariables>
    <ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
  <Implementation><CoSimulation_StandAlone><Capabilities/></CoSimulation_StandAlone></Implementation>
</fmiModelDescription>"""


def axis_with(old: str, new: str) -> str:
    assert old in AXIS
    return AXIS.replace(old, new)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            axis_with('"kp" =', '"Kp" ='),
            "twin.toml: [gains] 'Kp': no FMU variable 'Kp'; did you mean 'kp'?",
        ),
        (
            axis_with('= "position"', '= "positon"'),
            "twin.toml: [outputs] 'position': no FMU variable 'positon'; did you mean 'position'?",
        ),
        (
            axis_with('reference = "reference"', 'reference = "position"'),
            "twin.toml: [inputs] 'reference': expected an input of the FMU, 'position' is of "
            "causality output; such are reference, port.force, port.command, port.sensor",
        ),
        (
            axis_with('= "position"', '= "reference"'),
            "[outputs] 'position': expected an output of the FMU, 'reference' is of causality "
            "input",
        ),
        (
            AXIS + "[parameters]\nmas = 90.0\n",
            "[parameters] 'mas': no FMU variable 'mas'; did you mean 'mass'?",
        ),
        (
            AXIS + "[parameters]\nmass = 0.5\n",
            "[parameters] parameter 'mass': expected a value within [1, 10000] kg, the FMU's "
            "bounds, got 0.5",
        ),
        (
            axis_with("[40.0, 320.0]", "[-40.0, 320.0]"),
            "[gains] parameter 'kp': expected a value within [0, 10000] s-1, the FMU's bounds, "
            "got -40",
        ),
        (
            AXIS + "[uncertain]\nmass = [0.1, 2.0]\n",
            "[uncertain] parameter 'mass': expected a value within [1, 10000] kg",
        ),
        (
            AXIS + "[ports]\ntorque = 'force'\n",
            "[ports] 'torque': expected an input of the FMU, 'force' is of causality output; such "
            "are reference, port.force, port.command, port.sensor",
        ),
        (
            AXIS + "[states]\nvelocity = 'velo'\n",
            "[states] 'velocity': no FMU variable 'velo'; did you mean 'velocity'?",
        ),
        (
            AXIS + "[roles]\ninertia = 'position'\n",
            "[roles] 'inertia': expected a parameter of the FMU, 'position' is of causality output",
        ),
        (
            AXIS + "[initial]\ninitial_position = 'possition'\n",
            "[initial] 'initial_position': no signal 'possition'; did you mean 'position'?",
        ),
        (
            AXIS + "[initial]\ninitial_pos = 0.0\n",
            "[initial] 'initial_pos': no FMU variable 'initial_pos'; did you mean "
            "'initial_position'?",
        ),
        (
            axis_with('"drive_voltage"\n', '{ variable = "drive_voltage", scale = "kpp" }\n'),
            "[outputs] 'drive_voltage' scale: no FMU variable 'kpp'; did you mean 'kp'?",
        ),
        (
            axis_with("[outputs]", 'target = "reference"\n[outputs]'),
            "[inputs] 'target': signal 'reference' drives 'reference' already",
        ),
        (
            LOOP.replace("plant.true_position", "plant.true_positio", 1),
            "[wires] 'controller.measured': no FMU variable 'plant.true_positio'; did you mean "
            "'plant.true_position'?",
        ),
        (
            LOOP.replace('"plant.port.force"', '"plant.force"'),
            "[wires] 'plant.force': expected an input of the FMU",
        ),
        (
            LOOP.replace("kp = 500.0", "kpp = 500.0"),
            "[fmus] 'controller': no parameter 'kpp' of pd_filtered; did you mean 'kp'?",
        ),
        (
            LOOP.replace("kp = 500.0", "kp = -1.0"),
            "[fmus] 'controller' parameter 'controller.kp': expected a value within [0, 1e+09]",
        ),
        (
            LOOP.replace("[outputs]", 'x = "controller.measured"\n[outputs]'),
            "[wires] 'controller.measured': signal 'x' of [inputs] drives it already",
        ),
    ],
)
def test_a_name_that_does_not_fit_gives_one_line(
    text: str, message: str, write_twin: WriteTwin
) -> None:
    with pytest.raises(TwinFileError, match=re.escape(message)) as caught:
        FmuTwin(write_twin(text))
    assert "\n" not in str(caught.value)


def test_an_integer_parameter_takes_whole_numbers_only(write_twin: WriteTwin) -> None:
    path = write_twin(FAULTY + "[parameters]\nfault = 1.5\n", TEST_FMUS / "faulty.fmu")
    with pytest.raises(TwinFileError, match="'fault': expected a whole number, it is of type Int"):
        FmuTwin(path)


def test_a_missing_fmu_is_named_with_its_twin_file(write_twin: WriteTwin, tmp_path: Path) -> None:
    path = write_twin(AXIS, tmp_path / "absent.fmu")
    with pytest.raises(FmuFileError, match=r"twin\.toml: no FMU at '.*absent\.fmu'; check"):
        FmuTwin(path)


def test_model_exchange_says_what_to_ask_the_vendor_for(write_twin: WriteTwin) -> None:
    path = write_twin(FAULTY, TEST_FMUS / "model_exchange.fmu")
    with pytest.raises(
        FmuFileError, match=r"is for model exchange only: expected co-simulation.*ask its vendor"
    ):
        FmuTwin(path)


def test_a_foreign_platform_says_what_it_has_and_what_to_ask_for(write_twin: WriteTwin) -> None:
    path = write_twin(FAULTY, TEST_FMUS / "no_binary.fmu")
    with pytest.raises(
        FmuFileError, match=r"has no binary for this machine.*it has \w+; ask its vendor for an FMI"
    ):
        FmuTwin(path)


def test_other_fmi_versions_are_refused_with_the_cure(
    write_twin: WriteTwin, repack: Repack
) -> None:
    fmu = repack(members={"modelDescription.xml": FMI_1.encode()})
    words = r"is FMI 1\.0: expected FMI 2\.0 or 3\.0; ask its vendor"
    with pytest.raises(FmuFileError, match=words):
        FmuTwin(write_twin(AXIS, fmu))


def test_a_name_given_for_all_runs_is_checked_when_the_twin_is_opened(axis: Path) -> None:
    with pytest.raises(InputError, match=r"no FMU parameter 'mas'.*did you mean 'mass'"):
        FmuTwin(axis, parameters={"mas": 90.0})
    with pytest.raises(InputError, match=r"'mass': expected a value within \[1, 10000\] kg"):
        FmuTwin(axis, parameters={"mass": -1.0})


def test_our_controllers_need_no_path_and_take_their_settings(write_twin: WriteTwin) -> None:
    with FmuTwin(write_twin(LOOP)) as twin:
        assert twin.parameter_tunable()["controller.kp"]
        assert not twin.parameter_tunable()["plant.initial_position"]
