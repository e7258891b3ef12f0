"""SSP 1.0: a package becomes a twin that moves as the same FMUs joined by hand."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from typer.testing import CliRunner

from gmfbo import FmuTwin
from gmfbo.cli.application import app
from gmfbo.errors import FmuFileError, GmfboError, InputError
from gmfbo.recordings import Recording
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.inspection.inspection import inspect_fmu
from gmfbo.sources.inspection.ssp_import import import_ssp
from tests.sources.conftest import LOOP

if TYPE_CHECKING:
    from tests.sources.conftest import WriteTwin

SPACES = " ".join(
    f'xmlns:{short}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for short, name in (
        ("ssd", "Description"),
        ("ssc", "Common"),
        ("ssv", "ParameterValues"),
    )
)
CONTROLLER = """
<ssd:Component name="controller" source="resources/pd_filtered.fmu">
  <ssd:Connectors>
    <ssd:Connector name="reference" kind="input"><ssc:Real/></ssd:Connector>
    <ssd:Connector name="measured" kind="input"><ssc:Real/></ssd:Connector>
    <ssd:Connector name="u" kind="output"><ssc:Real/></ssd:Connector>
  </ssd:Connectors>
  <ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>
    <ssv:ParameterSet version="1.0" name="gains"><ssv:Parameters>
      <ssv:Parameter name="kp"><ssv:Real value="99.0"/></ssv:Parameter>
      <ssv:Parameter name="sample_time"><ssv:Real value="1e-3"/></ssv:Parameter>
    </ssv:Parameters></ssv:ParameterSet>
  </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>
</ssd:Component>"""
PLANT = """
<ssd:Component name="plant" source="resources/linear_axis.fmu"
  type="application/x-fmu-sharedlibrary">
  <ssd:Connectors>
    <ssd:Connector name="port.force" kind="input"><ssc:Real/></ssd:Connector>
    <ssd:Connector name="true_position" kind="output"><ssc:Real/></ssd:Connector>
  </ssd:Connectors>
</ssd:Component>"""
PARAMETERS = """
<ssd:ParameterBindings>
  <ssd:ParameterBinding source="resources/plant.ssv"/>
</ssd:ParameterBindings>"""
VALUES = f"""<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet {SPACES} version="1.0" name="plant"><ssv:Parameters>
  <ssv:Parameter name="controller.kp"><ssv:Real value="500.0"/></ssv:Parameter>
  <ssv:Parameter name="plant.kp"><ssv:Real value="0.0"/></ssv:Parameter>
  <ssv:Parameter name="plant.kv"><ssv:Real value="0.0"/></ssv:Parameter>
  <ssv:Parameter name="plant.mass"><ssv:Real value="2.0"/></ssv:Parameter>
  <ssv:Parameter name="plant.viscous_friction"><ssv:Real value="60.0"/></ssv:Parameter>
</ssv:Parameters></ssv:ParameterSet>"""


def wire(start_element: str, start: str, end_element: str, end: str) -> str:
    """A connection; the system itself has no element's name."""
    attributes = {
        "startElement": start_element,
        "startConnector": start,
        "endElement": end_element,
        "endConnector": end,
    }
    given = " ".join(f'{key}="{value}"' for key, value in attributes.items() if value)
    return f"<ssd:Connection {given}/>"


OUTSIDE = """
<ssd:Connectors>
  <ssd:Connector name="reference" kind="input"><ssc:Real/></ssd:Connector>
  <ssd:Connector name="position" kind="output"><ssc:Real/></ssd:Connector>
  <ssd:Connector name="force" kind="output"><ssc:Real/></ssd:Connector>
</ssd:Connectors>"""
FLAT = f"""{OUTSIDE}{PARAMETERS}
<ssd:Elements>{CONTROLLER}{PLANT}</ssd:Elements>
<ssd:Connections>
  {wire("", "reference", "controller", "reference")}
  {wire("controller", "u", "plant", "port.force")}
  {wire("controller", "measured", "plant", "true_position")}
  {wire("plant", "true_position", "", "position")}
  {wire("controller", "u", "", "force")}
</ssd:Connections>"""
NESTED = f"""{OUTSIDE}
<ssd:Elements>{CONTROLLER}
  <ssd:System name="drive">
    <ssd:Connectors>
      <ssd:Connector name="in" kind="input"><ssc:Real/></ssd:Connector>
      <ssd:Connector name="way" kind="output"><ssc:Real/></ssd:Connector>
    </ssd:Connectors>
    <ssd:Elements>{PLANT}</ssd:Elements>
    <ssd:Connections>
      {wire("", "in", "plant", "port.force")}
      {wire("plant", "true_position", "", "way")}
    </ssd:Connections>
  </ssd:System>
</ssd:Elements>
<ssd:Connections>
  {wire("", "reference", "controller", "reference")}
  {wire("controller", "u", "drive", "in")}
  {wire("drive", "way", "controller", "measured")}
  {wire("drive", "way", "", "position")}
  {wire("controller", "u", "", "force")}
</ssd:Connections>"""


def pack(folder: Path, inside: str, *, head: str = "") -> Path:
    path = folder / "loop.ssp"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(
            "SystemStructure.ssd",
            f'<?xml version="1.0" encoding="UTF-8"?>{head}<ssd:SystemStructureDescription {SPACES} '
            f'version="1.0" name="loop"><ssd:System name="servo loop">{inside}</ssd:System>'
            "</ssd:SystemStructureDescription>",
        )
        archive.writestr("resources/plant.ssv", VALUES)
        for name in ("pd_filtered", "linear_axis"):
            archive.write(models_folder() / f"{name}.fmu", f"resources/{name}.fmu")
    return path


def wave() -> Recording:
    time = np.arange(300, dtype=np.float64) * 1e-3
    return Recording(time=time, signals={"reference": 0.05 * np.sin(20.0 * time)})


def test_a_package_moves_as_the_twin_that_is_written_by_hand(
    tmp_path: Path, write_twin: WriteTwin
) -> None:
    """Its system sets `kp` over what its component says; one connection is written backwards."""
    made = import_ssp(pack(tmp_path, FLAT), tmp_path / "out")
    assert (made.fmus, made.wires, made.inputs, made.outputs) == (2, 2, 1, 2)
    assert made.twin == tmp_path / "out" / "servo_loop.toml"
    with FmuTwin(made.twin) as imported, FmuTwin(write_twin(LOOP)) as by_hand:
        runs = [twin.run({}, wave()) for twin in (imported, by_hand)]
    assert np.ptp(runs[0].signals["position"]) > 1e-2
    for name in ("position", "force"):
        assert runs[0].signals[name].tobytes() == runs[1].signals[name].tobytes()


def test_a_system_within_the_system_is_made_flat(tmp_path: Path) -> None:
    made = import_ssp(pack(tmp_path, NESTED), tmp_path / "out")
    text = made.twin.read_text()
    assert 'drive_plant = "resources/linear_axis.fmu"' in text
    assert '"drive_plant.port.force" = "controller.u"' in text
    assert '"controller.measured" = "drive_plant.true_position"' in text
    assert 'position = "drive_plant.true_position"' in text
    with FmuTwin(made.twin) as twin:
        assert twin.run({}, wave()).status == "ok"


def test_gmfbo_import_tells_what_it_wrote_and_never_overwrites(tmp_path: Path) -> None:
    package, out = pack(tmp_path, FLAT), tmp_path / "out"
    shown = CliRunner().invoke(app, ["import", str(package), "--out", str(out)])
    assert shown.exit_code == 0, shown.output
    assert "2 FMUs, 2 wires, 1 input, 2 outputs -> " in shown.output
    (out / "servo_loop.toml").write_text("mine")
    with pytest.raises(InputError, match="is there already; give another --out, or move it away"):
        import_ssp(package, out)
    assert (out / "servo_loop.toml").read_text() == "mine"


FACTOR = wire("plant", "true_position", "", "position").removesuffix("/>") + ">"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            FACTOR[:-1] + "/>",
            f'{FACTOR}<ssc:LinearTransformation factor="2.0"/></ssd:Connection>',
            "has a LinearTransformation: expected connections and parameters that pass values",
        ),
        (
            '<ssv:Real value="99.0"/>',
            '<ssv:String value="steel"/>',
            r"parameter 'kp' of 'controller' is of type String \(steel\): expected Real, Integer",
        ),
        (
            '<ssv:Real value="1e-3"/>',
            '<ssv:Enumeration value="fast"/>',
            r"parameter 'sample_time' of 'controller' is of type Enumeration \(fast\)",
        ),
        (
            '<ssv:Real value="1e-3"/>',
            '<ssv:Real value="1 ms"/>',
            "'sample_time' of 'controller': expected a number or truth value, got '1 ms'",
        ),
        (
            '<ssv:Real value="99.0"/>',
            "<ssv:Real/>",
            "parameter 'kp' of 'controller': expected a number or truth value, got 'None'",
        ),
        ("pd_filtered.fmu", "gone.fmu", "component 'controller': no FMU 'resources/gone.fmu' in"),
        ("pd_filtered.fmu", "../pd_filtered.fmu", r"no FMU 'resources/\.\./pd_filtered.fmu' in"),
        ("resources/pd_filtered.fmu", "inner.ssp", "is 'inner.ssp': expected an FMU in the packa"),
        ('name="u" kind', 'name="v" kind', "no FMU variable 'controller.v'"),
        ("<ssd:Elements>", "<ssd:Elements", "SystemStructure.ssd is not valid XML"),
        ("<ssd:Elements>", "<ssd:Elements><ssd:Odd/>", "cannot be read .*expected SSP 1.0"),
    ],
)
def test_what_a_twin_file_cannot_say_is_refused_by_name(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    assert old in FLAT
    inside = FLAT.replace(old, new)
    if 'name="v"' in new:
        inside = inside.replace('Connector="u"', 'Connector="v"')
    with pytest.raises(GmfboError, match=words) as caught:
        import_ssp(pack(tmp_path, inside), tmp_path / "out")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_entities_are_refused_before_they_are_read(tmp_path: Path) -> None:
    head = '<!DOCTYPE ssd [<!ENTITY a "b">]>'
    with pytest.raises(FmuFileError, match="declares a document type; expected plain XML"):
        import_ssp(pack(tmp_path, FLAT, head=head), tmp_path / "out")


def test_an_archive_without_a_structure_is_no_package(tmp_path: Path) -> None:
    with pytest.raises(FmuFileError, match=r"is no SSP package: expected SystemStructure\.ssd"):
        import_ssp(models_folder() / "pid.fmu", tmp_path)


def test_a_package_that_is_taken_for_an_fmu_is_told_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(FmuFileError, match="is an SSP package of several FMUs: gmfbo"):
        inspect_fmu(pack(tmp_path, FLAT))
