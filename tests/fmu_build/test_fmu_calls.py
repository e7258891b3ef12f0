"""The generic FMI wrapper, tried on the linear axis: phases, values, states, instances."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from fmu_build.compile import find_compiler
from fmu_build.fmu import WRAPPER
from fmu_build.platforms import this_platform
from tests.fmu_build.fmu_instance import FmuInstance

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

STEP = 1e-3
OUTPUTS = ["position", "velocity", "drive_voltage", "force"]
REFERENCE = {"reference": np.where(np.arange(300) >= 20, 0.01, 0.0)}


def test_reset_brings_back_the_start(new_instance: NewInstance) -> None:
    used = new_instance("linear_axis").start(mass=50.0, kp=100.0)
    used.run(REFERENCE, OUTPUTS, STEP)
    used.slave.reset()
    fresh = new_instance("linear_axis").start()
    np.testing.assert_array_equal(
        used.start().run(REFERENCE, OUTPUTS, STEP), fresh.run(REFERENCE, OUTPUTS, STEP)
    )


def test_a_restored_state_continues_identically(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis").start()
    axis.run(REFERENCE, OUTPUTS, STEP, rows=50)
    state = axis.slave.getFMUstate()
    first = axis.run(REFERENCE, OUTPUTS, STEP, first=50, rows=100)
    axis.slave.setFMUstate(state)
    second = axis.run(REFERENCE, OUTPUTS, STEP, first=50, rows=100)
    axis.slave.freeFMUstate(state)
    assert np.ptp(first[:, 0]) > 1e-3
    np.testing.assert_array_equal(first, second)


def test_a_serialised_state_continues_in_another_instance(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis").start(kp=120.0)
    axis.run(REFERENCE, OUTPUTS, STEP, rows=50)
    state = axis.slave.getFMUstate()
    stored = axis.slave.serializeFMUstate(state)
    axis.slave.freeFMUstate(state)
    expected = axis.run(REFERENCE, OUTPUTS, STEP, first=50, rows=100)

    other = new_instance("linear_axis").start()
    restored = other.slave.deSerializeFMUstate(stored)
    other.slave.setFMUstate(restored)
    other.slave.freeFMUstate(restored)
    np.testing.assert_array_equal(other.run(REFERENCE, OUTPUTS, STEP, first=50, rows=100), expected)


def test_a_state_of_another_model_is_refused(new_instance: NewInstance) -> None:
    pid = new_instance("pid").start()
    state = pid.slave.getFMUstate()
    stored = pid.slave.serializeFMUstate(state)
    pid.slave.freeFMUstate(state)
    axis = new_instance("linear_axis").start()
    with pytest.raises(Exception, match="fmi2DeSerializeFMUstate failed"):
        axis.slave.deSerializeFMUstate(stored)
    assert "another model or version of linear_axis" in axis.messages[-1]


def test_instances_do_not_touch_each_other(new_instance: NewInstance) -> None:
    alone = new_instance("linear_axis").start().run(REFERENCE, OUTPUTS, STEP)
    one = new_instance("linear_axis").start()
    two = new_instance("linear_axis").start(mass=40.0, kv=100.0)
    rows = []
    for k in range(300):
        for axis in (one, two):
            axis.set(reference=float(REFERENCE["reference"][k]))
            axis.step(k * STEP, STEP)
        rows.append([one.get(name) for name in OUTPUTS])
    np.testing.assert_array_equal(np.array(rows), alone[1:])


@pytest.mark.parametrize("divisor", [2, 3, 10])
def test_a_smaller_communication_step_moves_nothing(
    new_instance: NewInstance, divisor: int
) -> None:
    """The controller samples at 1 kHz whatever the communication step is."""
    coarse = new_instance("linear_axis").start().run(REFERENCE, OUTPUTS, STEP)
    fine_reference = {"reference": np.repeat(REFERENCE["reference"], divisor)}
    fine = new_instance("linear_axis").start().run(fine_reference, OUTPUTS, STEP / divisor)
    np.testing.assert_allclose(fine[::divisor], coarse, rtol=0.0, atol=1e-8)


def test_a_longer_communication_step_samples_within(new_instance: NewInstance) -> None:
    fine = new_instance("linear_axis").start()
    coarse = new_instance("linear_axis").start()
    held = {"reference": np.full(100, 0.01)}
    expected = fine.run(held, OUTPUTS, STEP)[::5]
    np.testing.assert_allclose(
        coarse.run({"reference": held["reference"][::5]}, OUTPUTS, 5 * STEP), expected, atol=1e-10
    )


def test_steps_of_mixed_length_end_where_equal_steps_end(new_instance: NewInstance) -> None:
    even = new_instance("linear_axis").start(reference=0.01)
    mixed = new_instance("linear_axis").start(reference=0.01)
    for k in range(100):
        even.step(k * STEP, STEP)
    lengths = np.random.default_rng(0).uniform(2e-4, 3e-3, 200)
    times = np.concatenate([[0.0], np.cumsum(lengths)])
    times = np.append(times[times < 0.0995], 0.1)
    for now, following in pairwise(times):
        mixed.step(now, following - now)
    assert even.get("position") == pytest.approx(mixed.get("position"), abs=1e-12)


def test_start_time_only_shifts_the_time_axis(new_instance: NewInstance) -> None:
    at_zero = new_instance("linear_axis").start(reference=0.01)
    later = new_instance("linear_axis").start(time=7.3e4 + 0.0007, reference=0.01)
    for k in range(200):
        at_zero.step(k * STEP, STEP)
        later.step(7.3e4 + 0.0007 + k * STEP, STEP)
    assert later.get("position") == pytest.approx(at_zero.get("position"), abs=1e-9)


def test_outputs_follow_values_set_while_initialising(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis")
    axis.slave.setupExperiment(startTime=0.0)
    axis.slave.enterInitializationMode()
    assert axis.get("position") == 0.0
    axis.set(initial_position=0.25)
    assert axis.get("position") == 0.25
    axis.slave.exitInitializationMode()
    assert axis.get("position") == 0.25


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("mass", -1.0, r"'mass' = -1 kg is refused: expected a value from 1 to 10000"),
        ("mass", np.nan, r"'mass' = -?nan kg is refused"),
        ("reference", np.inf, r"'reference' = inf m is refused"),
        ("position", 0.0, r"'position' is computed by the model and cannot be set"),
    ],
)
def test_a_bad_value_is_named_with_its_bounds(
    new_instance: NewInstance, name: str, value: float, message: str
) -> None:
    axis = new_instance("linear_axis")
    before = axis.get(name)
    with pytest.raises(RuntimeError, match=message):
        axis.set(**{name: value})
    assert axis.get(name) == before


def test_one_bad_value_in_a_call_leaves_all_values(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis")
    references = [axis.variables[name].valueReference for name in ("kp", "mass")]
    with pytest.raises(Exception, match="fmi2SetReal failed"):
        axis.slave.setReal(references, [100.0, -1.0])
    assert axis.get("kp") == 160.18


def test_a_fixed_parameter_is_refused_in_the_run_and_a_tunable_one_acts(
    new_instance: NewInstance,
) -> None:
    axis = new_instance("linear_axis").start()
    with pytest.raises(RuntimeError, match="parameter 'sample_time' is fixed"):
        axis.set(sample_time=2e-3)
    axis.set(kp=10.0, reference=0.001)
    axis.step(0.0, STEP)
    assert axis.get("drive_voltage") == pytest.approx(243.45 * 10.0 * 0.001, rel=1e-14)


def test_a_contradiction_between_parameters_is_refused_and_undone(
    new_instance: NewInstance,
) -> None:
    pid = new_instance("pid").start(u_min=-2.0, u_max=2.0)
    with pytest.raises(RuntimeError, match="'u_min' is greater than 'u_max'"):
        pid.set(u_max=-3.0)
    assert pid.get("u_max") == 2.0
    with pytest.raises(Exception, match="fmi2ExitInitializationMode failed"):
        new_instance("pid").start(u_min=1.0, u_max=0.0)


def test_an_unknown_value_reference_and_a_wrong_type_are_named(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis")
    with pytest.raises(Exception, match="fmi2GetReal failed"):
        axis.slave.getReal([99])
    assert "no variable with value reference 99: expected 0 to 16" in axis.messages[-1]
    with pytest.raises(Exception, match="fmi2GetInteger failed"):
        axis.slave.getInteger([0])
    assert axis.messages[-1] == "'reference' is of type Real and was accessed as Integer"


def test_a_step_from_another_time_is_refused(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis").start()
    axis.step(0.0, STEP)
    with pytest.raises(RuntimeError, match=r"step from 0.5 s .* the model stands at 0.001 s"):
        axis.step(0.5, STEP)
    with pytest.raises(RuntimeError, match=r"must be positive, got -0\.001 s"):
        axis.step(STEP, -STEP)
    axis.step(STEP, STEP)


def test_calls_out_of_order_are_refused(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis")
    with pytest.raises(RuntimeError, match="fmi2DoStep is not allowed in this phase"):
        axis.step(0.0, STEP)
    axis.start()
    with pytest.raises(Exception, match="fmi2EnterInitializationMode failed"):
        axis.slave.enterInitializationMode()
    axis.slave.terminate()
    with pytest.raises(RuntimeError, match="'reference' cannot be set after the simulation"):
        axis.set(reference=0.0)


def test_a_foreign_guid_is_refused(unpacked: Callable[[str], Path]) -> None:
    with pytest.raises(Exception, match="Failed to instantiate model"):
        FmuInstance(unpacked("linear_axis"), guid="0" * 32)


def test_resources_path_is_decoded_from_its_uri(tmp_path: Path, zig_cache: Path) -> None:
    """A blank and a percent sign in the path survive; checked on the wrapper's own function."""
    for name in ("resources.c", "resources.h"):
        shutil.copy(WRAPPER / name, tmp_path)
    (tmp_path / "visible.c").write_text(
        '#include "resources.h"\n'
        '__attribute__((visibility("default"))) char *decode(const char *uri);\n'
        "char *decode(const char *uri) { return path_of_uri(uri); }\n"
    )
    compiler = find_compiler("zig", zig_cache, [this_platform()])
    compiler.shared_library(tmp_path, ["resources.c", "visible.c"], "decoding", this_platform())
    library = ctypes.CDLL(str(next(tmp_path.glob("decoding.*"))))
    library.decode.restype = ctypes.c_char_p
    for path in ("/tmp/a b/100 % done/resources", "/plain"):
        assert library.decode(Path(path).as_uri().encode()) == path.encode()
    assert library.decode(b"file:///tmp/folder/") == b"/tmp/folder"
    assert library.decode(b"file:/tmp/folder") == b"/tmp/folder"
    assert library.decode(b"file://localhost/tmp/folder") == b"/tmp/folder"
    assert library.decode(b"/tmp/50%20") == b"/tmp/50%20"
