"""A drive that was on before the first row is no fault of its recording."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin, check
from gmfbo.diagnosis import Check
from gmfbo.diagnosis.locating.controller_memory import beside_memory
from gmfbo.recordings.recording import Recording
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin

Array = NDArray[np.float64]

TWIN = """
name = "arm"
step = 1e-3
[fmus]
controller = "{models}/pid.fmu"
motor = "{models}/motor_bench.fmu"
[wires]
"controller.measured" = "motor.position"
"motor.current" = "controller.u"
[inputs]
reference = {{ variable = "controller.reference", interpolation = "hold" }}
[outputs]
position = "motor.position"
current = "controller.u"
[parameters]
"controller.kp" = 25.0
"controller.ki" = {ki}
"controller.kd" = 0.3
"controller.filter_time" = {filter_time}
"controller.feedforward" = 0.0
"controller.u_min" = -8.0
"controller.u_max" = 8.0
[initial]
"motor.initial_position" = "position"
[ports]
{torque}
sensor = "controller.measured"
[states]
position = "motor.position"
velocity = "motor.velocity"
current = "motor.motor_current"
command = "controller.u"
"""
LOAD = {"constant_torque_offset.level": 0.05}
HELD_S = 1.0
CONTROLLERS: dict[str, dict[str, float]] = {
    "integral and filter": {"ki": 80.0, "filter_time": 4e-3},
    "integral alone": {"ki": 80.0, "filter_time": 0.0},
    "reading before": {"ki": 0.0, "filter_time": 0.0},
}


def arm(folder: Path, controller: Mapping[str, float], torque: str = "") -> FmuTwin:
    path = folder / f"arm{len(torque)}.toml"
    path.write_text(
        TWIN.format(models=models_folder().as_posix(), torque=torque, **controller),
        encoding="utf-8",
    )
    return FmuTwin(path)


def recorded(
    folder: Path, controller: Mapping[str, float], *, before: float = HELD_S
) -> list[Recording]:
    """The arm carries a load; the first row comes `before` seconds [s] after the drive is on."""
    time = np.arange(3000, dtype=np.float64) * 1e-3
    asked = 0.3 * np.sin(2.0 * np.pi * 0.7 * time) + 0.2 * np.sin(2.0 * np.pi * 1.9 * time)
    noise = 3e-5 * np.random.default_rng(3).standard_normal(time.size)
    twin = arm(folder, controller, 'torque = "motor.tau_load"')
    with AugmentedTwin(twin, substeps=10, isolated=False) as simulator:
        given = Recording(time=time, signals={"reference": asked, "position": 0.0 * time})
        plan = simulator.plan(given, {})
        run = simulator.run(plan, {}, LOAD, excitation={"sensor": noise})
    first = round(before / 1e-3)
    signals = {
        "reference": asked,
        "position": run.states["position"] + noise,
        "current": run.held["current"] + 2e-3 * np.random.default_rng(4).standard_normal(3000),
    }
    cut = {name: column[first:] for name, column in signals.items()}
    return [Recording(time=time[first:] - time[first], signals=cut, name="rec.csv")]


def seen(folder: Path, controller: Mapping[str, float], recordings: list[Recording]) -> Check:
    return check(arm(folder, controller), recordings, jobs=1)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_what_a_controller_held_before_the_first_row_is_no_fault_of_it(
    name: str, tmp_path: Path
) -> None:
    own = CONTROLLERS[name]
    found = seen(tmp_path, own, recorded(tmp_path, own))
    assert found.recordings["rec.csv"].parity < 3.0
    kinds = [finding.kind for finding in found.findings]
    assert kinds == (["held_before"] if own["ki"] else [])
    assert abs(found.recordings["rec.csv"].alignment["current"].shift) < 1e-4
    for finding in found.findings:
        assert "its integral held that before the first row, or" in finding.what
        assert "offset =" not in finding.cure


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_wrong_gain_of_a_drive_that_was_on_before_is_told(name: str, tmp_path: Path) -> None:
    """Negative control: no memory makes what another gain makes."""
    own = CONTROLLERS[name]
    recordings = recorded(tmp_path, own)
    other = arm(tmp_path, own)
    text = other.path.read_text(encoding="utf-8").replace('kp" = 25.0', 'kp" = 22.0')
    other.path.write_text(text, encoding="utf-8")
    found = check(FmuTwin(other.path), recordings, jobs=1)
    assert found.recordings["rec.csv"].parity > 3.0


def test_an_offset_beside_a_controller_without_an_integral_is_told(tmp_path: Path) -> None:
    """Negative control: such a controller holds no constant."""
    own = CONTROLLERS["reading before"]
    (recording,) = recorded(tmp_path, own)
    off = recording.with_signals({"current": recording.signals["current"] + 0.1})
    (finding,) = seen(tmp_path, own, [off]).findings
    assert finding.kind == "offset_column"
    assert "0.1" in finding.what


def test_an_offset_beside_an_integral_is_told_as_either(tmp_path: Path) -> None:
    own = CONTROLLERS["integral and filter"]
    (recording,) = recorded(tmp_path, own, before=0.0)
    off = recording.with_signals({"current": recording.signals["current"] + 0.1})
    found = seen(tmp_path, own, [off])
    assert [finding.kind for finding in found.findings] == ["held_before"]
    assert np.isnan(found.recordings["rec.csv"].alignment["current"].offset)
    # Negative control: as it was recorded.
    assert seen(tmp_path, own, [recording]).findings == ()


def test_beside_a_memory_only_what_it_cannot_explain_is_left() -> None:
    time = np.linspace(0.0, 1.0, 200)
    memory = np.column_stack([np.ones(200), np.exp(-time / 0.1)])
    other = np.sin(20.0 * time)
    values = other + memory @ [3.0, -2.0]
    values[:5] = np.nan
    left = beside_memory(values, memory)
    assert np.isnan(left[:5]).all()
    np.testing.assert_allclose(memory[5:].T @ left[5:], 0.0, atol=1e-9)
    np.testing.assert_allclose(left, beside_memory(np.where(time < 5 / 200, np.nan, other), memory))
    # A controller that keeps nothing.
    np.testing.assert_array_equal(beside_memory(values, np.zeros((200, 0))), values)
