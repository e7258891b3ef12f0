"""FMI 3.0 co-simulation: the same axis in both versions, every type, and what is refused."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from fmpy import simulate_fmu
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from gmfbo import FmuTwin
from gmfbo.cli.application import app
from gmfbo.errors import ExportError, FmuFileError, InputError, TwinFileError
from gmfbo.recordings import Recording
from gmfbo.sources.binding.bind import bind
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.export.exportable import check_exportable
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.inspection.inspection import inspect_fmu
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from gmfbo.sources.twin.parameter_values import run_parameters
from gmfbo.sources.twin.run_plan import Experiment
from gmfbo.sources.twin_file.twin_file import TwinFile
from gmfbo.sources.worker.runner import InProcess, Result
from tests.sources.conftest import AXIS, LOOP, TEST_FMUS

if TYPE_CHECKING:
    from tests.sources.conftest import Repack, WriteTwin

AXIS_2, AXIS_3 = (models_folder() / f"linear_axis{version}.fmu" for version in ("", "_fmi3"))
TYPES = TEST_FMUS / "fmi3_types.fmu"
REALS = ("float64", "float32")
WHOLE = {
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32)},
    "int64": (-(2**53), 2**53),  # a double counts exactly to 2^53
    "uint64": (0, 2**53),
    "boolean": (0, 1),
    "gear": (1, 2),
}
NAMES = (*REALS, *WHOLE)
PASS_THROUGH = f"""
name = "types"
fmu = "FMU"
step = 1e-3
[inputs]
{"".join(f'{name} = "in.{name}"' + chr(10) for name in NAMES)}
[outputs]
{"".join(f'out_{name} = "out.{name}"' + chr(10) for name in NAMES)}
"""


def chirp(rows: int = 400) -> Recording:
    time = np.arange(rows, dtype=np.float64) * 1e-3
    return Recording(time=time, signals={"reference": 0.05 * np.sin(200.0 * time**2)})


def binding_of(path: Path) -> Binding:
    return bind(TwinFile.read(path), path.parent, path.name)


def both_ways(path: Path, recording: Recording, **parameters: float) -> tuple[Result, Result]:
    """Stepped by the C master and in Python."""
    binding = binding_of(path)
    chosen = run_parameters(binding, recording, parameters, {})
    order = Experiment.prepare(binding, recording, chosen, binding.file.step).order(0)
    results = []
    for native in (True, False):
        runner = InProcess(binding, native=native)
        results.append(runner.run(order)[0])
        runner.close()
    return results[0], results[1]


def test_the_axis_gives_the_same_bits_in_both_versions(write_twin: WriteTwin) -> None:
    runs = [both_ways(write_twin(AXIS, fmu), chirp(), kp=120.0) for fmu in (AXIS_2, AXIS_3)]
    tables = [result.y.tobytes() for pair in runs for result in pair]
    assert np.ptp(runs[0][0].y[:, 0]) > 1e-2
    assert tables == tables[:1] * 4


def test_one_line_swaps_the_version_in_a_worker(write_twin: WriteTwin) -> None:
    trajectories = []
    for fmu in (AXIS_2, AXIS_3):
        with FmuTwin(write_twin(AXIS, fmu)) as twin:
            trajectories.append(twin.run({"kp": 90.0, "kv": 200.0}, chirp()))
    one, other = trajectories
    assert one.status == other.status == "ok"
    for name in ("position", "drive_voltage"):
        np.testing.assert_array_equal(one.signals[name], other.signals[name])


def test_fmpy_simulates_our_fmi_3_build_to_the_same_end() -> None:
    """An importer that shares no code with the driver; it needs every function of the standard."""
    arguments = {"stop_time": 0.3, "output_interval": 1e-3, "start_values": {"reference": 0.01}}
    two, three = (simulate_fmu(str(fmu), **arguments) for fmu in (AXIS_2, AXIS_3))
    np.testing.assert_array_equal(two["position"], three["position"])
    assert three["position"].max() > 0.009


def test_our_fmi_3_build_has_no_findings_and_all_platforms() -> None:
    report = inspect_fmu(AXIS_3)
    assert (report.fmi_version, report.findings, report.obstacle) == ("3.0", (), "")
    assert len(report.platforms) == 5
    two = {v.name: (v.unit, v.start, v.minimum, v.maximum) for v in inspect_fmu(AXIS_2).parameters}
    three = {v.name: (v.unit, v.start, v.minimum, v.maximum) for v in report.parameters}
    assert two == three


def test_fmus_of_both_versions_are_wired_together(write_twin: WriteTwin) -> None:
    """The controller is FMI 2.0, the plant FMI 3.0."""
    runs = [both_ways(write_twin(LOOP, fmu), chirp()) for fmu in (AXIS_2, AXIS_3)]
    tables = [result.y.tobytes() for pair in runs for result in pair]
    assert np.ptp(runs[0][0].y[:, 1]) > 1.0
    assert tables == tables[:1] * 4


def test_physics_acts_on_a_twin_of_either_version_alike(write_twin: WriteTwin) -> None:
    """`physics.fmu` is FMI 2.0 and is stepped beside the twin."""
    ports = '[ports]\ntorque = "port.force"\n[states]\nvelocity = "velocity"\n'
    positions = []
    for fmu in (AXIS_2, AXIS_3):
        with AugmentedTwin(FmuTwin(write_twin(AXIS + ports, fmu)), substeps=2) as twin:
            run = twin.run(twin.plan(chirp(), {}), {}, {"coulomb_friction.level": 20.0})
            positions.append(run.held["position"])
    assert np.ptp(positions[0]) > 1e-2
    assert positions[0].tobytes() == positions[1].tobytes()


@settings(max_examples=30)
@given(data=st.data())
def test_a_value_of_every_type_passes_unchanged(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("types") / "twin.toml"
    path.write_text(PASS_THROUGH.replace("FMU", str(TYPES)))
    values = {
        "float64": data.draw(st.floats(-1e300, 1e300)),
        "float32": data.draw(st.floats(-(2.0**100), 2.0**100, width=32)),
        **{name: data.draw(st.integers(low, high)) for name, (low, high) in WHOLE.items()},
    }
    time = np.arange(3, dtype=np.float64) * 1e-3
    signals = {name: np.full(3, float(value)) for name, value in values.items()}
    native, python = both_ways(path, Recording(time=time, signals=signals))
    assert native.outcome.status == "ok"
    assert native.y.tobytes() == python.y.tobytes()
    np.testing.assert_array_equal(native.y[1:], [list(map(float, values.values()))] * 2)


@pytest.mark.parametrize(
    ("demand", "status", "rows", "words"),
    [
        (1, "failed", 4, "asks for event mode before t = 0.004 s: gmfbo steps at fixed comm"),
        (2, "failed", 4, "'fmi3_types.fmu' ended the simulation before t = 0.004 s"),
        (3, "failed", 4, "asks for event mode before t = 0.004 s: gmfbo steps at fixed comm"),
        (4, "diverged", 4, "an output is not finite at t = 0.004 s"),
        (5, "ok", 11, ""),
        (6, "failed", 4, "refused fmi3DoStep with 'error': 100 % asked for at t = 0.003 s"),
    ],
)
def test_a_step_that_does_not_end_well_is_told(
    write_twin: WriteTwin, demand: int, status: str, rows: int, words: str
) -> None:
    time = np.arange(11, dtype=np.float64) * 1e-3
    signals = {name: np.ones(11) for name in NAMES}
    path = write_twin(PASS_THROUGH, TYPES)
    native, python = both_ways(path, Recording(time=time, signals=signals), demand=demand, at=4e-3)
    assert native.outcome == python.outcome
    assert native.y.tobytes() == python.y.tobytes()
    assert (native.outcome.status, native.outcome.rows) == (status, rows)
    assert words in native.outcome.message
    assert native.outcome.warnings == (7 if demand == 5 else 0)


def test_an_array_is_refused_by_name_and_its_elements_are_told(write_twin: WriteTwin) -> None:
    shown = CliRunner().invoke(app, ["inspect", str(TYPES)]).output
    assert "runs here: yes" in shown
    assert "  vector[1] = 0\n  vector[2] = 0\n  vector[3] = 0\n" in shown
    text = PASS_THROUGH.replace('"in.float64"', '"vector"')
    with pytest.raises(
        TwinFileError,
        match=r"'vector' is an array of 3; name one of its elements, such as 'vector\[1\]'",
    ):
        binding_of(write_twin(text, TYPES))


def test_a_clock_is_refused_by_name(repack: Repack, write_twin: WriteTwin) -> None:
    kind = 'causality="input" intervalVariability="triggered"'
    clock = f'<Clock name="tick" valueReference="400" {kind}/>'
    fmu = repack(TYPES, edits={"</ModelVariables>": f"{clock}</ModelVariables>"})
    words = r"has the clock 'tick': expected an FMU without clocks, since .* ask its vendor"
    with pytest.raises(FmuFileError, match=words):
        binding_of(write_twin(PASS_THROUGH, fmu))
    assert "has the clock 'tick'" in inspect_fmu(fmu).obstacle


def test_scheduled_execution_alone_is_refused_by_name(repack: Repack) -> None:
    fmu = repack(TYPES, edits={"<CoSimulation .*/>": '<ScheduledExecution modelIdentifier="a"/>'})
    assert "is for scheduled execution only: expected co-simulation" in inspect_fmu(fmu).obstacle


def test_another_token_is_refused_with_the_words_of_the_fmu(
    repack: Repack, write_twin: WriteTwin
) -> None:
    fmu = repack(TYPES, edits={'instantiationToken="fmi3_types"': 'instantiationToken="other"'})
    with FmuTwin(write_twin(PASS_THROUGH, fmu)) as twin:
        run = twin.run({}, Recording(np.array([0.0, 1e-3]), {name: np.ones(2) for name in NAMES}))
    assert run.status == "failed"
    assert "fmi3InstantiateCoSimulation: the instantiation token is another" in run.message


def test_a_library_of_another_name_and_folder_is_found(
    repack: Repack, write_twin: WriteTwin
) -> None:
    with zipfile.ZipFile(AXIS_3) as archive:
        libraries = [name for name in archive.namelist() if name.startswith("binaries/")]
    rename = {name: name.replace("linear_axis", "other") for name in libraries}
    with FmuTwin(write_twin(AXIS, repack(AXIS_3, rename=rename))) as twin:
        assert twin.run({}, chirp(20)).status == "ok"


def test_a_whole_number_is_asked_for_where_the_type_is_one(write_twin: WriteTwin) -> None:
    with pytest.raises(InputError, match="'demand': expected a whole number, it is of type Int32"):
        FmuTwin(write_twin(PASS_THROUGH, TYPES), parameters={"demand": 0.5})


def test_no_augmented_fmu_is_promised_of_fmi_3(write_twin: WriteTwin) -> None:
    with pytest.raises(ExportError, match=r"is FMI 3\.0: expected FMI 2\.0, which the augmented"):
        check_exportable(binding_of(write_twin(AXIS, AXIS_3)))
