"""The linear axis: its integrator, its Modelica plant and its sampled controller, by oracles."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from fmu_build.build import SOURCES
from fmu_build.compile import find_compiler
from fmu_build.failure import BuildError
from fmu_build.platforms import this_platform
from fmu_build.translate import check_translation

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

MASS, FRICTION, GAIN, KP, KV, STEP = 95.1089, 203.5034, 35.1507, 160.18, 243.45, 1e-3
Slope = Callable[[float, NDArray[np.float64], float], NDArray[np.float64]]


def test_the_integrator_converges_with_fourth_order(new_instance: NewInstance) -> None:
    """Constant force on m v' = F - d v: v(t) = F/d (1 - exp(-t d/m))."""
    mass, friction, force, end = 1.0, 5000.0, 10.0, 4e-4
    exact = force / friction * (1.0 - np.exp(-end * friction / mass))
    errors = []
    for divisions in (4, 8, 16, 32):
        axis = new_instance("linear_axis").start(
            mass=mass, viscous_friction=friction, kp=0.0, kv=0.0, port__force=force
        )
        for k in range(divisions):
            axis.step(k * end / divisions, end / divisions)
        errors.append(abs(axis.get("velocity") - exact))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(np.abs(orders - 4.0) < 0.35), orders


def test_free_motion_follows_the_closed_form(new_instance: NewInstance) -> None:
    """x(t) = F/d (t - m/d (1 - exp(-t d/m))) under a constant force, by default parameters."""
    axis = new_instance("linear_axis").start(kp=0.0, kv=0.0, port__force=50.0)
    table = axis.run({}, ["true_position", "velocity"], STEP, rows=500)
    t = np.arange(501) * STEP
    rate = FRICTION / MASS
    velocity = 50.0 / FRICTION * (1.0 - np.exp(-rate * t))
    position = 50.0 / FRICTION * (t - (1.0 - np.exp(-rate * t)) / rate)
    np.testing.assert_allclose(table, np.column_stack([position, velocity]), rtol=0.0, atol=1e-13)


def test_steady_velocity_is_force_over_friction(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis").start(kp=0.0, kv=0.0, port__command=2.0)
    table = axis.run({}, ["velocity", "force"], 0.1, rows=200)
    assert table[-1, 0] == pytest.approx(2.0 * GAIN / FRICTION, rel=1e-12)
    assert table[-1, 1] == pytest.approx(2.0 * GAIN, rel=1e-15)


def test_without_friction_the_work_of_the_drive_is_the_kinetic_energy(
    new_instance: NewInstance,
) -> None:
    axis = new_instance("linear_axis").start(viscous_friction=0.0)
    reference = {"reference": 0.05 * np.sin(np.arange(400) * 0.02)}
    table = axis.run(reference, ["true_position", "velocity", "force"], STEP)
    work = np.sum(table[1:, 2] * np.diff(table[:, 0]))  # the force is constant over each step
    assert work == pytest.approx(0.5 * MASS * table[-1, 1] ** 2, rel=1e-9)


def closed_loop(slope: Slope, reference: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of position, velocity and voltage: the README's controller around `solve_ivp`."""
    state = np.zeros(2)
    one_ago = two_ago = 0.0
    rows = [[0.0, 0.0, 0.0]]
    for k, wanted in enumerate(reference):
        filtered_rate = (state[0] - two_ago) / (2.0 * STEP)
        voltage = float(np.clip(KV * (KP * (wanted - state[0]) - filtered_rate), -10.0, 10.0))
        one_ago, two_ago = state[0], one_ago
        solution = solve_ivp(
            slope, (k * STEP, (k + 1) * STEP), state, args=(voltage,), rtol=1e-12, atol=1e-15
        )
        state = solution.y[:, -1]
        rows.append([state[0], state[1], voltage])
    return np.array(rows)


def written_slope(t: float, y: NDArray[np.float64], voltage: float) -> NDArray[np.float64]:
    """The equations as the literature writes them."""
    return np.array([y[1], (GAIN * voltage - FRICTION * y[1]) / MASS])


@pytest.fixture(scope="module")
def generated_slope(tmp_path_factory: pytest.TempPathFactory, zig_cache: Path) -> Slope:
    """`rhs` of the C that was translated from Modelica, compiled by itself."""
    folder = tmp_path_factory.mktemp("generated")
    for name in ("LinearAxis.c", "LinearAxis.h"):
        shutil.copy(SOURCES / "linear_axis" / name, folder)
    (folder / "visible.c").write_text(
        '#include "LinearAxis.h"\n'
        '__attribute__((visibility("default"))) void slope(double t, const double *y,\n'
        "    const double *p, double *w, double *dy) { rhs(t, y, p, w, dy); }\n"
    )
    compiler = find_compiler("zig", zig_cache, [this_platform()])
    compiler.shared_library(folder, ["LinearAxis.c", "visible.c"], "generated", this_platform())
    library = ctypes.CDLL(str(next(folder.glob("generated.*"))))
    vector = np.ctypeslib.ndpointer(dtype=np.float64, flags="C")
    library.slope.argtypes = [ctypes.c_double, vector, vector, vector, vector]
    library.slope.restype = None

    def slope(t: float, y: NDArray[np.float64], voltage: float) -> NDArray[np.float64]:
        derivatives, workspace = np.empty(2), np.empty(10)
        parameters = np.array([MASS, FRICTION, GAIN, voltage, 0.0])
        library.slope(t, np.ascontiguousarray(y), parameters, workspace, derivatives)
        return derivatives

    return slope


def test_fmu_generated_code_and_written_equations_agree(
    new_instance: NewInstance, generated_slope: Slope
) -> None:
    """A step that saturates and a sine: all three closed loops are one trajectory."""
    k = np.arange(250)
    reference = np.where(k < 100, 0.0, 0.004 * (k > 110)) + 1e-3 * np.sin(0.05 * k)
    fmu = new_instance("linear_axis").start()
    simulated = fmu.run(
        {"reference": reference}, ["true_position", "velocity", "drive_voltage"], STEP
    )
    written = closed_loop(written_slope, reference)
    generated = closed_loop(generated_slope, reference)
    assert np.max(np.abs(written[:, 2])) == 10.0  # the limit is part of the comparison
    np.testing.assert_allclose(generated, written, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(simulated[:, :2], written[:, :2], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(simulated[:, 2], written[:, 2], rtol=0.0, atol=1e-8)


def test_the_command_output_after_a_step_is_the_one_computed_at_its_beginning(
    new_instance: NewInstance,
) -> None:
    """Row k + 1 of the FMU holds vir(t_k): the logger's convention `logged = "new"`."""
    axis = new_instance("linear_axis").start(initial_position=0.02)
    assert axis.get("drive_voltage") == 0.0
    axis.set(reference=0.0201)
    axis.step(0.0, STEP)
    assert axis.get("drive_voltage") == pytest.approx(KV * KP * 1e-4, rel=1e-12)


def test_each_port_adds_to_its_signal(new_instance: NewInstance) -> None:
    """Ports at zero change nothing; the sensor port reaches controller and reading alike."""
    axis = new_instance("linear_axis").start(initial_position=0.02, port__sensor=0.001)
    assert axis.get("position") == pytest.approx(0.021, abs=1e-15)
    assert axis.get("true_position") == 0.02
    axis.set(reference=0.02, port__command=0.5)
    axis.step(0.0, STEP)
    assert axis.get("drive_voltage") == -10.0  # 243.45 * 160.18 * -0.001 V is beyond the limit
    assert axis.get("force") == pytest.approx(GAIN * -9.5, rel=1e-14)


@pytest.mark.parametrize("port", ["port__force", "port__command", "port__sensor"])
def test_a_port_at_zero_is_the_axis_without_it(new_instance: NewInstance, port: str) -> None:
    reference = {"reference": np.full(100, 1e-3)}
    names = ["true_position", "drive_voltage"]
    without = new_instance("linear_axis").start().run(reference, names, STEP)
    at_zero = new_instance("linear_axis").start(**{port: 0.0}).run(reference, names, STEP)
    pushed = new_instance("linear_axis").start(**{port: 1e-4}).run(reference, names, STEP)
    np.testing.assert_array_equal(at_zero, without)
    assert np.max(np.abs(pushed - without)) > 1e-9


def test_a_recorded_lap_of_the_twin_reads_like_the_rig(new_instance: NewInstance) -> None:
    """The command that the FMU shows is the one that the controller's formula gives."""
    reference = 0.01 * (1.0 - np.cos(np.arange(400) * 0.01))
    table = (
        new_instance("linear_axis")
        .start()
        .run({"reference": reference}, ["position", "drive_voltage"], STEP)
    )
    qm, vir = table[:-1, 0], table[1:, 1]  # row k of a log whose command is the new one
    mean = (qm + np.concatenate([[0.0], qm[:-1]])) / 2.0
    rate = (mean - np.concatenate([[0.0], mean[:-1]])) / STEP
    np.testing.assert_allclose(vir, KV * (KP * (reference - qm) - rate), rtol=0.0, atol=1e-9)


def test_the_voltage_limit_keeps_an_unstable_loop_bounded(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis").start(
        kp=1e4, kv=1e5, force_gain=1000.0, voltage_limit=1000.0, mass=1.0, viscous_friction=0.0
    )
    table = axis.run({"reference": np.full(200, 1e-3)}, ["true_position"], STEP)
    assert np.ptp(table) > 1.0
    assert np.all(np.isfinite(table))


def test_divergence_is_reported_in_words(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis").start(mass=1.0, viscous_friction=0.0, port__force=1e307)
    with pytest.raises(RuntimeError, match="the axis has diverged"):
        axis.run({}, ["true_position"], 1.0, rows=100)


def test_a_changed_modelica_source_is_not_built_from_old_c(tmp_path: Path) -> None:
    folder = tmp_path / "linear_axis"
    shutil.copytree(SOURCES / "linear_axis", folder)
    check_translation(folder)
    source = folder / "LinearAxis.mo"
    source.write_text(source.read_text().replace("mass *", "2 * mass *"))
    with pytest.raises(BuildError, match=r"LinearAxis\.mo differs .* --translate on Python 3\.12"):
        check_translation(folder)
