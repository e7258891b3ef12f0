"""The exported FMU in other hands: plain FMI calls, and a process without gmfbo."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave

from gmfbo.sources.export.export import AugmentedFmu
from gmfbo.sources.stepping.fmu_log import FmuLog
from tests.sources.export.exported import CASES, STEPS, diagnosed, excitation, export_case

MASS, LEVEL = "mass", "physics.coulomb_friction.level"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> AugmentedFmu:
    return export_case(CASES["axis"], tmp_path_factory.mktemp("axis"))


class Slave:
    """An instance of the exported FMU, as an importing tool has it."""

    def __init__(self, path: Path, folder: Path) -> None:
        description = read_model_description(str(path))
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.slave = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=extract(
                str(path), str(folder / f"{path.stem}{len(list(folder.iterdir()))}")
            ),
        )
        self.slave.instantiate()

    def __getitem__(self, name: str) -> float:
        return float(self.slave.getReal([self.references[name]])[0])

    def __setitem__(self, name: str, value: float) -> None:
        self.slave.setReal([self.references[name]], [value])

    def setup(self, start: float = 0.0) -> None:
        self.slave.setupExperiment(startTime=start)

    def initialise(self) -> None:
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def step(self, steps: int, h: float, start: float = 0.0) -> list[float]:
        positions = []
        for k in range(steps):
            self.slave.doStep(start + k * h, h)
            positions.append(self["position"])
        return positions


@pytest.fixture
def slave(made: AugmentedFmu, tmp_path: Path) -> Iterator[Slave]:
    one = Slave(made.fmu, tmp_path)
    yield one
    one.slave.freeInstance()


PLAIN = """
import json, sys
import fmpy, numpy as np
fmu, start_values = sys.argv[1], json.loads(sys.argv[2])
reference = np.array(json.loads(sys.stdin.read()))
column = np.zeros(reference.size, dtype=[("time", float), ("reference", float)])
column["time"], column["reference"] = np.arange(reference.size) * 1e-3, reference
result = fmpy.simulate_fmu(fmu, stop_time=(reference.size - 1) * 1e-3, output_interval=1e-3,
                           input=column, start_values=start_values, output=["position"])
assert not any(name.split(".")[0] == "gmfbo" for name in sys.modules)
print("RESULT " + json.dumps(list(result["position"])))
"""


def test_it_runs_in_a_process_without_gmfbo(made: AugmentedFmu, tmp_path: Path) -> None:
    case, recording = CASES["axis"], excitation(CASES["axis"])
    done = subprocess.run(
        [sys.executable, "-c", PLAIN, str(made.fmu), "{}"],
        input=json.dumps(list(recording.signal("reference"))),
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
    )
    (line,) = (line for line in done.stdout.splitlines() if line.startswith("RESULT "))
    position = json.loads(line.removeprefix("RESULT "))
    assert np.array_equal(position, diagnosed(case, recording).held["position"])


@pytest.mark.parametrize("when", ["instantiated", "set up", "initialising"])
def test_a_tool_may_set_parameters_whenever_the_standard_lets_it(when: str, slave: Slave) -> None:
    assert (slave[MASS], slave[LEVEL]) == (80.0, 20.0)
    if when == "instantiated":
        slave[MASS], slave[LEVEL] = 123.0, 0.0
    slave.setup()
    if when == "set up":
        slave[MASS], slave[LEVEL] = 123.0, 0.0
    slave.slave.enterInitializationMode()
    if when == "initialising":
        slave[MASS], slave[LEVEL] = 123.0, 0.0
    slave.slave.exitInitializationMode()
    assert (slave[MASS], slave[LEVEL]) == (123.0, 0.0)


def test_a_reset_brings_back_the_identified_values_and_the_start(slave: Slave) -> None:
    slave.setup()
    slave.initialise()
    slave["reference"] = 0.01
    first = slave.step(50, 1e-3)
    slave[MASS], slave[LEVEL] = 123.0, 0.0
    slave.slave.terminate()
    slave.slave.reset()
    assert (slave[MASS], slave[LEVEL]) == (80.0, 20.0)
    slave.setup()
    slave.initialise()
    slave["reference"] = 0.01
    assert slave.step(50, 1e-3) == first


def test_instances_do_not_know_of_each_other(made: AugmentedFmu, tmp_path: Path) -> None:
    alone, other = Slave(made.fmu, tmp_path), Slave(made.fmu, tmp_path)
    for one, level in ((alone, 20.0), (other, 0.0)):
        one.setup()
        one.initialise()
        one["reference"], one[LEVEL] = 0.01, level
    expected = Slave(made.fmu, tmp_path)
    expected.setup()
    expected.initialise()
    expected["reference"] = 0.01
    interleaved = []
    for k in range(50):
        interleaved += alone.step(1, 1e-3, k * 1e-3)
        other.step(1, 1e-3, k * 1e-3)
    assert interleaved == expected.step(50, 1e-3)
    assert other["position"] != alone["position"]
    for one in (alone, other, expected):
        one.slave.freeInstance()


@pytest.mark.parametrize("multiple", [1, 7, 20])
def test_whole_multiples_of_the_internal_step_are_exact(
    multiple: int, made: AugmentedFmu, tmp_path: Path
) -> None:
    fine, coarse = Slave(made.fmu, tmp_path), Slave(made.fmu, tmp_path)
    for one in (fine, coarse):
        one.setup(100.0)
        one.initialise()
        one["reference"] = 0.01
    positions = fine.step(140, 1e-4, 100.0)
    assert (
        coarse.step(140 // multiple, multiple * 1e-4, 100.0) == positions[multiple - 1 :: multiple]
    )
    for one in (fine, coarse):
        one.slave.freeInstance()


@pytest.mark.parametrize("step", [5e-5, 1.5e-4, 1.0001e-3, 0.0, -1e-3])
def test_other_steps_are_refused(step: float, slave: Slave) -> None:
    slave.setup()
    slave.initialise()
    with pytest.raises(FMICallException, match="fmi2DoStep failed with status 3"):
        slave.slave.doStep(0.0, step)


def test_a_step_that_a_tool_rounded_is_taken(slave: Slave) -> None:
    slave.setup()
    slave.initialise()
    time = 0.0
    for _ in range(STEPS):
        # As tools do that compute the step from two rounded times.
        following = time + 1e-3
        slave.slave.doStep(time, following - time)
        time = following
    assert slave["reference"] == 0.0


def test_a_parameter_may_change_during_a_run(slave: Slave) -> None:
    slave.setup()
    slave.initialise()
    slave["reference"] = 0.05
    slave.step(20, 1e-3)
    slave[LEVEL] = 0.0
    assert slave[LEVEL] == 0.0
    changed = slave.step(20, 1e-3, 0.02)
    slave.slave.terminate()
    slave.slave.reset()
    slave.setup()
    slave.initialise()
    slave["reference"] = 0.05
    assert slave.step(40, 1e-3)[20:] != changed


def test_a_sound_instance_logs_no_line(made: AugmentedFmu, tmp_path: Path) -> None:
    """Run apart, since fmpy prints what an FMU logs."""
    script = f"import fmpy; fmpy.simulate_fmu({str(made.fmu)!r}, stop_time=0.01)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stdout == ""


def test_an_instance_that_cannot_be_made_says_why(made: AugmentedFmu, tmp_path: Path) -> None:
    folder = tmp_path / "broken"
    extract(str(made.fmu), str(folder))
    description = read_model_description(str(made.fmu))
    for missing, told in (
        ("00/binaries", "Cannot load"),
        ("runtime", "the container's runtime for this system cannot be loaded"),
        ("starts.txt", "starts.txt cannot be loaded"),
    ):
        (folder / "resources" / missing).rename(tmp_path / missing.replace("/", "-"))
        log = FmuLog()
        slave = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=str(folder),
        )
        with pytest.raises(Exception, match="Failed to instantiate"):
            slave.instantiate(callbacks=log.callbacks)
        assert told in " ".join(log.lines)
