"""The C master against plain stepping of the same FMUs, and its account of how a run ended."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fmu_build.platforms import this_platform
from gmfbo.sources.fmu_file.models import models_folder
from tests.fmu_build.fmu_instance import FmuInstance

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

STEP = 1e-3
TYPES = {"Real": 0, "Integer": 1, "Boolean": 2}
SET, DO_STEP, GET, NOT_FINITE = 1, 2, 3, 4
ALL_TYPES = 11  # of FMI 3.0; FMI 2.0 has the first three


class Fmu(ctypes.Structure):
    _fields_ = [
        ("component", ctypes.c_void_p),
        ("do_step", ctypes.c_void_p),
        ("set", ctypes.c_void_p * ALL_TYPES),
        ("get", ctypes.c_void_p * ALL_TYPES),
        ("fmi", ctypes.c_int32),
    ]

    @classmethod
    def of(cls, one: FmuInstance) -> Fmu:
        fmu = cls(component=one.slave.component, do_step=one.address("fmi2DoStep"), fmi=2)
        for name, kind in TYPES.items():
            fmu.set[kind] = one.address(f"fmi2Set{name}")
            fmu.get[kind] = one.address(f"fmi2Get{name}")
        return fmu


class Port(ctypes.Structure):
    _fields_ = [
        ("fmu", ctypes.c_int32),
        ("vr", ctypes.c_uint32),
        ("type", ctypes.c_int32),
        ("column", ctypes.c_int32),
    ]


class Wire(ctypes.Structure):
    _fields_ = [
        ("to_fmu", ctypes.c_int32),
        ("to_vr", ctypes.c_uint32),
        ("to_type", ctypes.c_int32),
        ("from_fmu", ctypes.c_int32),
        ("from_vr", ctypes.c_uint32),
        ("from_type", ctypes.c_int32),
        ("scale", ctypes.c_double),
    ]


class Result(ctypes.Structure):
    _fields_ = [
        ("status", ctypes.c_int32),
        ("fmu", ctypes.c_int32),
        ("stage", ctypes.c_int32),
        ("step", ctypes.c_int64),
        ("fmi_status", ctypes.c_int32),
        ("warnings", ctypes.c_int32),
    ]


@dataclass
class Run:
    """Arguments of gm_run by variable names; an end is (FMU index, variable)."""

    instances: list[FmuInstance]
    inputs: list[tuple[int, str]] = field(default_factory=list)
    outputs: list[tuple[int, str]] = field(default_factory=list)
    schedules: list[tuple[int, str]] = field(default_factory=list)
    wires: list[tuple[tuple[int, str], tuple[int, str], float]] = field(default_factory=list)
    start: float = 0.0
    result: Result = field(default_factory=Result)

    def _variable(self, end: tuple[int, str]) -> tuple[int, int, int]:
        variable = self.instances[end[0]].variables[end[1]]
        return end[0], variable.valueReference, TYPES[variable.type]

    def _ports(self, ends: list[tuple[int, str]]) -> Any:
        ports = [Port(*self._variable(end), column) for column, end in enumerate(ends)]
        return (Port * len(ports))(*ports)

    def __call__(
        self, u: NDArray[np.float64], s: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """Table of outputs, shape (rows of u + 1, outputs), NaN in rows that were not reached."""
        fmus = [Fmu.of(one) for one in self.instances]
        wires = [Wire(*self._variable(to), *self._variable(of), k) for to, of, k in self.wires]
        y = np.full((len(u) + 1, len(self.outputs)), np.nan)
        u = np.ascontiguousarray(u[:, None] if u.ndim == 1 else u)
        s = np.zeros((len(u), 0)) if s is None else np.ascontiguousarray(s[:, None])
        address = ctypes.POINTER(ctypes.c_double)
        platform = this_platform()
        folder = models_folder() / "master" / platform.name
        library = ctypes.CDLL(str(folder / f"gmfbo_master{platform.suffix}"))
        library.gm_run(
            len(fmus),
            (Fmu * len(fmus))(*fmus),
            ctypes.c_int64(len(u)),
            ctypes.c_double(self.start),
            ctypes.c_double(STEP),
            len(self.inputs),
            self._ports(self.inputs),
            u.ctypes.data_as(address),
            u.shape[1],
            len(self.schedules),
            self._ports(self.schedules),
            s.ctypes.data_as(address),
            s.shape[1],
            len(wires),
            (Wire * len(wires))(*wires),
            len(self.outputs),
            self._ports(self.outputs),
            y.ctypes.data_as(address),
            y.shape[1],
            ctypes.byref(self.result),
        )
        return y


REFERENCE = np.where(np.arange(200) >= 10, 0.01, 0.0)
AXIS_OUTPUTS = ["position", "velocity", "drive_voltage"]


def test_it_is_bit_identical_to_plain_stepping(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis").start()
    run = Run([axis], inputs=[(0, "reference")], outputs=[(0, name) for name in AXIS_OUTPUTS])
    table = run(REFERENCE)
    plain = new_instance("linear_axis").start().run({"reference": REFERENCE}, AXIS_OUTPUTS, STEP)
    np.testing.assert_array_equal(table, plain)
    assert (run.result.status, run.result.warnings) == (0, 0)


def wired_pair(new_instance: NewInstance) -> Run:
    """A pd controller before an axis whose own controller is switched off."""
    controller = new_instance("pd_filtered").start(kp=500.0, kd=20.0)
    axis = new_instance("linear_axis").start(kp=0.0, kv=0.0)
    return Run(
        [controller, axis],
        inputs=[(0, "reference")],
        outputs=[(0, "u"), (1, "true_position")],
        wires=[((1, "port.command"), (0, "u"), 1.0), ((0, "measured"), (1, "position"), 1.0)],
    )


def test_wires_carry_the_newest_outputs_in_the_stated_order(new_instance: NewInstance) -> None:
    table = wired_pair(new_instance)(REFERENCE)
    controller = new_instance("pd_filtered").start(kp=500.0, kd=20.0)
    axis = new_instance("linear_axis").start(kp=0.0, kv=0.0)
    rows = [[controller.get("u"), axis.get("true_position")]]
    for k, wanted in enumerate(REFERENCE):
        controller.set(reference=float(wanted), measured=axis.get("position"))
        controller.step(k * STEP, STEP)
        axis.set(port__command=controller.get("u"))
        axis.step(k * STEP, STEP)
        rows.append([controller.get("u"), axis.get("true_position")])
    np.testing.assert_array_equal(table, np.array(rows))
    assert np.ptp(table[:, 1]) > 1e-3


def test_a_scaled_wire_and_an_external_input_add_up_at_one_variable(
    new_instance: NewInstance,
) -> None:
    source = new_instance("faulty").start()
    target = new_instance("faulty").start()
    run = Run(
        [source, target],
        inputs=[(0, "reference"), (1, "reference")],
        outputs=[(1, "position")],
        wires=[((1, "reference"), (0, "position"), -2.0)],
    )
    u = np.random.default_rng(0).normal(size=(20, 2))
    np.testing.assert_array_equal(run(u)[1:, 0], u[:, 1] + -2.0 * u[:, 0])


def test_a_schedule_is_set_only_where_it_changes(new_instance: NewInstance) -> None:
    """The FMU logs an event for each change of a parameter, and for nothing else."""
    gain = new_instance("faulty").start()
    gain.slave.setDebugLogging(True, ["logEvents"])
    run = Run([gain], [(0, "reference")], [(0, "position")], schedules=[(0, "gain")])
    schedule = np.array([2.0, 2.0, 2.0, 5.0, 5.0, 1.0])
    np.testing.assert_array_equal(run(np.ones(6), schedule)[1:, 0], schedule)
    assert gain.messages == [
        "'gain' = 2 from 0 s on",
        "'gain' = 5 from 0.003 s on",
        "'gain' = 1 from 0.005 s on",
    ]


def test_a_schedule_of_a_fixed_parameter_is_refused_at_its_first_row(
    new_instance: NewInstance,
) -> None:
    axis = new_instance("linear_axis").start()
    run = Run([axis], outputs=[(0, "position")], schedules=[(0, "sample_time")])
    table = run(np.zeros((5, 0)), np.full(5, 1e-3))
    assert (run.result.status, run.result.stage, run.result.step) == (1, SET, 0)
    assert np.isfinite(table[0, 0])
    assert np.all(np.isnan(table[1:]))


def test_integers_and_booleans_pass_through_as_numbers(new_instance: NewInstance) -> None:
    pid = new_instance("pid").start(kp=1.0)
    run = Run(
        [pid],
        inputs=[(0, "measured"), (0, "measured_load")],
        outputs=[(0, "feedback_from_load"), (0, "u")],
        schedules=[(0, "feedback_from_load")],
    )
    u = np.tile([1.0, 3.0], (4, 1))
    table = run(u, np.array([0.0, 1.0, 1.0, 0.0]))
    np.testing.assert_array_equal(table[1:], [[0, -1], [1, -3], [1, -3], [0, -1]])
    faulty = new_instance("faulty").start(fault=9, at=1.0)
    run = Run([faulty], outputs=[(0, "fault"), (0, "stage")])
    np.testing.assert_array_equal(run(np.zeros((2, 0))), np.tile([9.0, 2.0], (3, 1)))


@pytest.mark.parametrize(("fault", "status"), [(5, 2), (6, 3)])
def test_a_refused_step_keeps_the_rows_before_it(
    new_instance: NewInstance, fault: int, status: int
) -> None:
    good = new_instance("faulty").start()
    bad = new_instance("faulty").start(fault=fault, at=0.007)
    run = Run([good, bad], inputs=[(0, "reference")], outputs=[(0, "position")])
    table = run(np.arange(1.0, 21.0))
    result = run.result
    assert (result.status, result.fmu, result.stage, result.step) == (1, 1, DO_STEP, 7)
    assert result.fmi_status == status
    np.testing.assert_array_equal(table[:8, 0], np.arange(8.0))
    assert np.all(np.isnan(table[8:]))


def test_a_value_that_is_not_finite_stops_the_run_with_its_row(new_instance: NewInstance) -> None:
    bad = new_instance("faulty").start(fault=4, at=0.007)
    run = Run([bad], inputs=[(0, "reference")], outputs=[(0, "position")])
    table = run(np.arange(1.0, 21.0))
    assert (run.result.status, run.result.stage, run.result.step) == (1, NOT_FINITE, 7)
    np.testing.assert_array_equal(table[:8, 0], np.arange(8.0))
    assert np.all(np.isnan(table[8:]))


def test_warnings_are_counted_and_go_on(new_instance: NewInstance) -> None:
    noisy = new_instance("faulty").start(fault=9, at=0.005)
    run = Run([noisy], inputs=[(0, "reference")], outputs=[(0, "position")])
    table = run(np.arange(1.0, 11.0))
    assert (run.result.status, run.result.warnings) == (0, 5)
    assert table[-1, 0] == 10.0


def test_a_refused_value_is_told_from_a_refused_step(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis").start()
    run = Run([axis], inputs=[(0, "reference")], outputs=[(0, "position")])
    run(np.array([0.0, 0.0, np.nan, 0.0]))
    assert (run.result.stage, run.result.step, run.result.fmi_status) == (SET, 2, 3)
    assert "'reference' = nan m is refused" in axis.messages[-1].replace("-nan", "nan")


def test_no_steps_read_the_first_row_only(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis").start(initial_position=0.3)
    run = Run([axis], outputs=[(0, "position")])
    np.testing.assert_array_equal(run(np.zeros((0, 0))), [[0.3]])
    assert run.result.status == 0


def test_the_time_of_a_step_is_a_multiple_and_not_a_sum(new_instance: NewInstance) -> None:
    """0.1 s added up 10,000 times would be off by 1.6e-10 s; the FMU's clock stands exactly."""
    axis = new_instance("linear_axis").start(time=0.1)
    run = Run([axis], outputs=[(0, "position")], start=0.1)
    run(np.zeros((10_000, 0)))
    assert run.result.status == 0
    assert axis.slave.getRealStatus(2) == (0.1 + 9999 * STEP) + STEP
    with pytest.raises(RuntimeError, match=r"the model stands at 10\.1 s"):
        axis.step(10.0, STEP)


def test_an_fmu_index_or_column_out_of_range_is_refused(new_instance: NewInstance) -> None:
    axis = new_instance("linear_axis").start()
    run = Run([axis], inputs=[(0, "reference")], outputs=[(0, "position")])
    run.inputs.append((0, "port.force"))
    run(np.zeros(5))  # one column for two inputs
    assert run.result.status == 3
