"""Step FMUs over arrays: by the C master, or in Python where there is none."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo.sources.fmu_file.job import Job, Port, ValueType
from gmfbo.sources.fmu_file.platforms import master_path
from gmfbo.sources.stepping.fmi2 import Instance
from gmfbo.sources.stepping.python_master import step_in_python
from gmfbo.sources.stepping.stop import Stop

_STOPPED = 1


class _Fmu(ctypes.Structure):
    _fields_ = [
        ("component", ctypes.c_void_p),
        ("do_step", ctypes.c_void_p),
        ("set", ctypes.c_void_p * len(ValueType)),
        ("get", ctypes.c_void_p * len(ValueType)),
        ("fmi", ctypes.c_int32),
    ]


class _Port(ctypes.Structure):
    _fields_ = [
        ("fmu", ctypes.c_int32),
        ("reference", ctypes.c_uint32),
        ("type", ctypes.c_int32),
        ("column", ctypes.c_int32),
    ]


class _Wire(ctypes.Structure):
    _fields_ = [
        ("to_fmu", ctypes.c_int32),
        ("to_reference", ctypes.c_uint32),
        ("to_type", ctypes.c_int32),
        ("from_fmu", ctypes.c_int32),
        ("from_reference", ctypes.c_uint32),
        ("from_type", ctypes.c_int32),
        ("scale", ctypes.c_double),
    ]


class _Result(ctypes.Structure):
    _fields_ = [
        ("status", ctypes.c_int32),
        ("fmu", ctypes.c_int32),
        ("stage", ctypes.c_int32),
        ("step", ctypes.c_int64),
        ("fmi_status", ctypes.c_int32),
        ("warnings", ctypes.c_int32),
    ]


def step_all(
    instances: Sequence[Instance],
    job: Job,
    u: NDArray[np.float64],
    s: NDArray[np.float64],
    y: NDArray[np.float64],
    *,
    native: bool = True,
) -> Stop:
    """Step initialised FMUs through a whole run.

    Parameters
    ----------
    instances : sequence of Instance
        In step mode, in order of computation.
    job : Job
        Variables that are set and read; `settings` are already in force.
    u, s : ndarray, shape (steps, n)
        Inputs and scheduled parameters, C-contiguous.
    y : ndarray, shape (steps + 1, n)
        Outputs, C-contiguous; filled row by row.
    native : bool
        Use the C master if there is one; Python gives the same bits. Elements of arrays are for
        Python only.
    """
    path = master_path() if native and not job.has_arrays else None
    if path is None:
        return step_in_python(instances, job, u, s, y)
    return _step_natively(path, instances, job, u, s, y)


def _step_natively(
    path: Path,
    instances: Sequence[Instance],
    job: Job,
    u: NDArray[np.float64],
    s: NDArray[np.float64],
    y: NDArray[np.float64],
) -> Stop:
    result = _Result()
    status = _load(path).gm_run(
        len(instances),
        (_Fmu * len(instances))(*(_fmu(instance) for instance in instances)),
        job.steps,
        job.start,
        job.step,
        len(job.inputs),
        _ports(job.inputs),
        u.ctypes.data,
        u.shape[1],
        len(job.schedules),
        _ports(job.schedules),
        s.ctypes.data,
        s.shape[1],
        len(job.wires),
        (_Wire * len(job.wires))(*(_Wire(*wire) for wire in job.wires)),
        len(job.outputs),
        _ports(job.outputs),
        y.ctypes.data,
        y.shape[1],
        ctypes.byref(result),
    )
    if status > _STOPPED:
        # Out of memory, or arguments that no valid job has.
        raise MemoryError(f"the C master refused a run with status {status}")
    return Stop(
        stopped=status == _STOPPED,
        fmu=result.fmu,
        stage=result.stage,
        step=result.step,
        fmi_status=result.fmi_status,
        warnings=result.warnings,
    )


@lru_cache(maxsize=1)
def _load(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    i32, i64, f64, pointer = ctypes.c_int32, ctypes.c_int64, ctypes.c_double, ctypes.c_void_p
    library.gm_run.restype = ctypes.c_int
    library.gm_run.argtypes = [
        *(i32, ctypes.POINTER(_Fmu), i64, f64, f64),
        *(i32, ctypes.POINTER(_Port), pointer, i32),
        *(i32, ctypes.POINTER(_Port), pointer, i32),
        *(i32, ctypes.POINTER(_Wire)),
        *(i32, ctypes.POINTER(_Port), pointer, i32),
        ctypes.POINTER(_Result),
    ]
    return library


def _fmu(instance: Instance) -> _Fmu:
    interface = instance.interface
    fmu = _Fmu(component=instance.component, fmi=interface.major)
    fmu.do_step = instance.address(interface.do_step)
    for kind in interface.words:
        fmu.set[kind] = instance.address(interface.setter(kind))
        fmu.get[kind] = instance.address(interface.getter(kind))
    return fmu


def _ports(ports: Sequence[Port]) -> ctypes.Array[_Port]:
    return (_Port * len(ports))(*(_Port(*port) for port in ports))
