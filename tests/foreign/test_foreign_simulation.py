"""FMUs of another maker: inspected, simulated, wired, joined to our controllers."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from gmfbo import FmuTwin, Recording
from gmfbo.errors import TwinFileError
from gmfbo.sources.inspection.inspection import inspect_fmu, starting_twin_file
from tests.foreign.fmus import foreign_fmu, write_own_axis, write_vendor_axis

MASS_DAMPER = """
name = "mass, spring and damper"
fmu = "FMU"
step = 1e-4
[inputs]
force = "f"
[outputs]
position = "mass.s"
velocity = "mass.v"
[parameters]
"spring.s_rel0" = 0.0
"fixed.s0" = 0.0
"mass.L" = 0.0
"spring.c" = 400.0
"""
SPRINGS = """
name = "two masses between walls, in two FMUs"
step = 1e-3
[fmus]
one = "ONE"
two = "TWO"
[wires]
"one.x2" = "two.x2"
"two.x1" = "one.x1"
[outputs]
x1 = "one.x1"
x2 = "two.x2"
v1 = "one.v1"
v2 = "two.v2"
"""
WHOLE = """
name = "two masses between walls"
fmu = "WHOLE"
step = 1e-3
[outputs]
x1 = "x1"
x2 = "x2"
v1 = "v1"
v2 = "v2"
"""
TYPES = """
name = "FMI 3.0 of another maker"
fmu = "FMU"
step = 1e-2
[outputs]
output = "OUTPUT"
"""


def still(rows: int, step: float) -> Recording:
    return Recording(time=np.arange(rows, dtype=np.float64) * step, signals={})


def wave(rows: int = 1000) -> Recording:
    time = np.arange(rows, dtype=np.float64) * 1e-3
    reference = 0.02 * np.sin(2.0 * np.pi * 2.0 * time)
    return Recording(time=time, signals={"reference": reference}, units={"reference": "m"})


def test_inspect_tells_what_it_is_and_what_is_wrong_with_it() -> None:
    path = foreign_fmu("Mass_Damper")
    command = [sys.executable, "-m", "gmfbo", "inspect", str(path)]
    shown = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert "FMI 2.0, co-simulation and model exchange" in shown
    assert "made by OpenModelica" in shown
    assert "runs here: yes" in shown
    assert "  damper.d [N.s/m] = 10 in [0, ]  Damping constant" in shown
    assert "findings: 1\n" in shown  # a name that the naming convention does not allow


def test_the_starting_twin_file_guesses_what_the_written_one_says() -> None:
    """The vendor names an output `y` without a unit; what it is stands among the locals."""
    text = starting_twin_file(inspect_fmu(foreign_fmu("Mass_Damper")))
    for line in (
        '# position = "mass.s"  # guess: a local variable, its name, unit m',
        '# velocity = "mass.v"  # guess: a local variable, its name, unit m/s',
        '# torque = "f"  # guess: it drives the plant, unit N',
        '# inertia = "mass.m"  # guess: the unit kg',
        '# "damper.d" = [5.0, 20.0]  # [N.s/m] Damping constant',
        '## "plant.f" = "controller.u"',
        '## "controller.measured" = "plant.mass.s"',
    ):
        assert f"\n{line}\n" in text
    springs = starting_twin_file(inspect_fmu(foreign_fmu("MassSpringSubSystem1")))
    assert '# k1 = "k1"\n' in springs  # a spring rate that begins at 1 is no signal
    assert '# position = "x1"  # guess: its name, without a unit' in springs


def test_a_force_step_gives_the_closed_form(tmp_path: Path) -> None:
    """m x'' + d x' + c x = F; its exporter's explicit Euler steps are the communication steps."""
    path = tmp_path / "twin.toml"
    path.write_text(MASS_DAMPER.replace("FMU", str(foreign_fmu("Mass_Damper")), 1))
    time = np.arange(5001, dtype=np.float64) * 1e-4
    with FmuTwin(path) as twin:
        run = twin.run({}, Recording(time=time, signals={"force": np.full(5001, 20.0)}))
    m, d, c = 1.0, 10.0, 400.0
    a, b = -d / (2.0 * m), np.sqrt(c / m - (d / (2.0 * m)) ** 2)
    envelope = np.exp(a * time)
    exact = 20.0 / c * (1.0 - envelope * (np.cos(b * time) - a / b * np.sin(b * time)))
    assert run.status == "ok"
    np.testing.assert_allclose(run.signals["position"], exact, rtol=0.0, atol=2e-3 * exact.max())


def spring_run(tmp_path: Path, text: str) -> NDArray[np.float64]:
    path = tmp_path / "springs.toml"
    path.write_text(text)
    with FmuTwin(path, step=1e-3) as twin:
        run = twin.run({}, still(3001, 1e-3))
    assert run.status == "ok"
    return np.column_stack([run.signals[name] for name in ("x1", "x2", "v1", "v2")])


def test_two_fmus_joined_by_wires_move_as_the_whole(tmp_path: Path) -> None:
    """Three unit springs and two unit masses from the FMU's own start, by matrix exponential."""
    parts = SPRINGS.replace("ONE", str(foreign_fmu("MassSpringSubSystem1")))
    parts = parts.replace("TWO", str(foreign_fmu("MassSpringSubSystem2")))
    joined = spring_run(tmp_path, parts)
    whole = spring_run(tmp_path, WHOLE.replace("WHOLE", str(foreign_fmu("MassSpringSystem"))))
    stiffness = np.array([[-2.0, 1.0], [1.0, -2.0]])
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [stiffness, np.zeros((2, 2))]])
    exact = np.array([expm(system * t) @ whole[0] for t in np.arange(0, 3001, 100) * 1e-3])
    assert np.ptp(whole[:, 0]) > 0.5
    np.testing.assert_allclose(whole[::100], exact, atol=5e-3)
    np.testing.assert_allclose(joined, whole, atol=5e-3)


def test_a_constant_that_its_exporter_made_an_input_is_held_by_parameters(tmp_path: Path) -> None:
    text = WHOLE.replace("WHOLE", str(foreign_fmu("MassSpringSystem")))
    run = spring_run(tmp_path, text + "[parameters]\nk2 = 3.0\nm1 = 2.0\n")
    k1, k2, k3, m1, m2 = 1.0, 3.0, 1.0, 2.0, 1.0
    stiffness = np.array([[-(k1 + k2) / m1, k2 / m1], [k2 / m2, -(k2 + k3) / m2]])
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [stiffness, np.zeros((2, 2))]])
    exact = np.array([expm(system * t) @ run[0] for t in np.arange(0, 3001, 100) * 1e-3])
    # Explicit Euler grows by exp(h w^2 t / 2): about 1 % over 3 s at 2.6 rad/s.
    np.testing.assert_allclose(run[::100], exact, atol=0.01 * np.abs(exact).max())


def test_an_input_that_a_wire_drives_is_no_parameter(tmp_path: Path) -> None:
    path = write_vendor_axis(tmp_path)
    path.write_text(path.read_text().replace("[parameters]", '[parameters]\n"plant.f" = 1.0\n#'))
    with pytest.raises(TwinFileError, match="is of causality input; such are"):
        FmuTwin(path)


def test_our_controller_and_a_foreign_plant_follow_as_our_own_plant_does(tmp_path: Path) -> None:
    """The same mass and damper; the foreign FMU steps by explicit Euler, ours by Runge-Kutta."""
    runs = []
    for path in (write_vendor_axis(tmp_path), write_own_axis(tmp_path)):
        with FmuTwin(path) as twin:
            runs.append(twin.run({"controller.kp": 3000.0}, wave()))
    vendor, own = runs
    assert vendor.status == own.status == "ok"
    for name in ("position", "force"):
        spread = np.ptp(own.signals[name])
        np.testing.assert_allclose(vendor.signals[name], own.signals[name], atol=0.03 * spread)
    assert not np.array_equal(vendor.signals["position"], own.signals["position"])


def test_a_name_that_the_foreign_fmu_lacks_is_told_with_the_nearest(tmp_path: Path) -> None:
    path = write_vendor_axis(tmp_path)
    path.write_text(path.read_text().replace('"plant.mass.m" =', '"plant.mass.n" ='))
    with pytest.raises(TwinFileError, match=r"no FMU variable 'plant.mass.n'.*'plant.mass.m'"):
        FmuTwin(path)


def test_fmi_3_of_another_maker_runs_and_its_array_is_refused(tmp_path: Path) -> None:
    """Its source says: the output begins at 3 and grows by `increment` each step."""
    path = tmp_path / "twin.toml"
    fmu = foreign_fmu("FMU3Model")
    report = inspect_fmu(fmu)
    assert (report.fmi_version, report.generation_tool) == ("3.0", "PythonFMU3 0.2.2")
    path.write_text(TYPES.replace("FMU", str(fmu), 1).replace("OUTPUT", "vector"))
    with pytest.raises(TwinFileError, match="'vector' is an array of 5"):
        FmuTwin(path)
    path.write_text(TYPES.replace("FMU", str(fmu), 1).replace("OUTPUT", "output"))
    with FmuTwin(path, parameters={"increment": 0.5}) as twin:
        run = twin.run({}, still(11, 1e-2))
    assert (run.status, run.message) == ("ok", "")
    np.testing.assert_array_equal(run.signals["output"], 3.0 + 0.5 * np.arange(11))
