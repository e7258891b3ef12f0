"""The truth simulator from Python: compiled once a machine, called through ctypes."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import os
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from subprocess import run

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

SOURCE = Path(__file__).with_name("truth.c")
SAMPLE = 1e-3
"""[s] Period of every controller and of every recording."""

PREROLL = 3000
"""Samples under the first reference before a recording, so that it starts at rest: integral parts
take a quarter of a second to forget an offset of the sensor, by e."""

KINDS = {"none": 0.0, "servo_pd": 1.0, "axis_pv": 2.0, "pid": 3.0, "cascade_p_pi": 4.0, "pd": 5.0}
"""Controllers; with none the reference is the command."""


@dataclass(frozen=True)
class TrueRun:
    """What happened at each t = k SAMPLE, each of shape (rows,).

    Attributes
    ----------
    reading : ndarray
        What the controller got.
    held, new : ndarray
        Command in force just before t, and the one computed at t.
    position, velocity : ndarray
        Of the motor.
    active : ndarray
        Share of the sample after t in which the plant stuck, was limited, crossed its gap or
        was pulsed.
    """

    reading: Vector
    held: Vector
    new: Vector
    position: Vector
    velocity: Vector
    active: Vector


class Diverged(ArithmeticError):
    """The plant left the finite numbers."""


@functools.cache
def _library() -> ctypes.CDLL:
    """Compile what is not in the cache; the name holds the hash of the source."""
    source = SOURCE.read_bytes()
    name = f"truth-{hashlib.sha256(source).hexdigest()[:16]}-{sys.platform}.lib"
    folder = Path(tempfile.gettempdir()) / f"gmfbo_blind_{getattr(os, 'getuid', int)()}"
    folder.mkdir(exist_ok=True)
    path = folder / name
    if not path.exists():
        partial = folder / f"{name}.{os.getpid()}"
        command = [sys.executable, "-m", "ziglang", "cc", "-std=c11", "-O2", "-ffp-contract=off"]
        command += ["-fno-sanitize=undefined", "-fvisibility=hidden", "-shared", "-fPIC"]
        done = run(
            [*command, "-o", str(partial), str(SOURCE), "-lm"], capture_output=True, text=True
        )
        if done.returncode:
            raise RuntimeError(f"truth.c does not compile:\n{done.stderr}")
        partial.replace(path)
    library = ctypes.CDLL(str(path))
    library.truth_name.restype = ctypes.c_char_p
    table = np.ctypeslib.ndpointer(dtype=np.float64, flags="C")
    library.truth_run.argtypes = [table, ctypes.c_long, ctypes.c_long, table, table, table, table]
    return library


@functools.cache
def parameter_names() -> tuple[str, ...]:
    """Names of all parameters, in the order of the C struct."""
    library = _library()
    return tuple(library.truth_name(i).decode() for i in range(library.truth_parameters()))


def simulate(
    parameters: Mapping[str, float],
    reference: Vector,
    noise: Vector | None = None,
    preroll: int = PREROLL,
    load: Vector | None = None,
) -> TrueRun:
    """One recording's worth of truth.

    Parameters
    ----------
    parameters : mapping of str to float
        Of `parameter_names`; those that are not given are zero.
    reference : ndarray, shape (rows,)
        Held from one sample to the next; the command itself for kind none.
    noise : ndarray, shape (preroll + rows,), optional
        Added to the readings.
    preroll : int
        Samples under the first reference, not recorded.
    load : ndarray, shape (preroll + rows,), optional
        [torque] On the motor beside all that the plant has, held over each sample.

    Raises
    ------
    KeyError
        For an unknown parameter.
    Diverged
        If the plant does.
    """
    library, names = _library(), parameter_names()
    unknown = set(parameters) - set(names)
    if unknown:
        raise KeyError(f"truth.c has no {sorted(unknown)}")
    values = np.array([float(parameters.get(name, 0.0)) for name in names])
    rows = len(reference)
    out = np.empty((rows, library.truth_columns()))
    added, pushed = _of_each_sample(noise, preroll + rows), _of_each_sample(load, preroll + rows)
    wanted = np.ascontiguousarray(reference, dtype=float)
    if library.truth_run(values, preroll, rows, wanted, added, pushed, out):
        raise Diverged("the true plant has diverged")
    return TrueRun(*(np.ascontiguousarray(column) for column in out.T))


def _of_each_sample(given: Vector | None, samples: int) -> Vector:
    """A noise as the library takes it; zeros where there is none."""
    if given is None:
        return np.zeros(samples)
    if given.shape != (samples,):
        raise ValueError(f"expected noise of shape ({samples},), got {given.shape}")
    return np.ascontiguousarray(given, dtype=float)
