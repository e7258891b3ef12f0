"""The twin's input that an experiment plays, and the column that moves the axis by it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import InputError
from gmfbo.sources.twin.twin import FmuTwin

Column = NDArray[np.float64]
Kind = Literal["position", "velocity", "effort"]

_LENGTHS, _SPEEDS = ("rad", "m"), ("rad/s", "m/s")
_EFFORTS = ("N.m", "N", "A", "V")


@dataclass(frozen=True)
class PlayedInput:
    """Input that an experiment plays.

    Attributes
    ----------
    name : str
        Signal of [inputs].
    unit : str
        SI unit.
    kind : {"position", "velocity", "effort"}
        A reference that a controller follows, a velocity that is imposed, or a torque, force,
        current or voltage that moves the plant.
    start : float
        [unit] Its value at rest.
    """

    name: str
    unit: str
    kind: Kind
    start: float


def played_input(twin: FmuTwin) -> PlayedInput:
    """Choose the input that an experiment plays; others keep the twin's values.

    Raises
    ------
    InputError
        None of its inputs moves the axis.
    """
    variables = twin.binding.variables
    units = {name: variables[e.variable].variable.si_unit for name, e in twin.file.inputs.items()}
    ranked = sorted(units, key=lambda name: (_rank(name, units[name]), list(units).index(name)))
    if not ranked or _rank(ranked[0], units[ranked[0]]) > 4:
        raise InputError(
            f"{twin.name}: expected an input that moves the axis (reference, velocity, torque or "
            f"current), got {', '.join(units) or 'none'}; name one under [inputs]"
        )
    name = ranked[0]
    variable = variables[twin.file.inputs[name].variable].variable
    start = 0.0 if variable.start is None else float(variable.start) * variable.to_si
    kind: Kind = "effort"
    if units[name] in _SPEEDS:
        kind = "velocity"
    elif units[name] in _LENGTHS or name == "reference":
        kind = "position"
    return PlayedInput(name, units[name], kind, start if kind == "position" else 0.0)


def _rank(name: str, unit: str) -> int:
    if name == "reference":
        return 0
    for rank, units in enumerate((_LENGTHS, _EFFORTS, _SPEEDS), start=1):
        if unit in units:
            return rank
    return 9


def imposed_velocity(motion: Column, spacing: float) -> Column:
    """Velocity, held from each row to the next, that yields a motion.

    Parameters
    ----------
    motion : ndarray, shape (rows,)
        [rad or m]
    spacing : float
        [s]
    """
    return np.append(np.diff(motion) / spacing, 0.0)


def effort_for(
    motion: Column, spacing: float, moved: Callable[[Column], Column], size: float
) -> Column:
    """Effort that makes a plant follow a motion: a p'' + b p' + c (p - p0).

    The motion under each of the three terms alone is simulated, and their sum is fitted to the
    wanted motion: exact for a linear mass, damper and spring with any gain.

    Parameters
    ----------
    motion : ndarray, shape (rows,)
        [rad or m] From rest to rest.
    spacing : float
        [s]
    moved : callable (effort) -> position
        [rad or m] Simulated, relative to the start.
    size : float
        [unit of the effort] Amplitude at which each term is simulated.

    Raises
    ------
    InputError
        No term of the effort moves the plant.
    """
    shapes = [
        np.gradient(np.gradient(motion, spacing), spacing),
        np.gradient(motion, spacing),
        motion - motion[0],
    ]
    tried = [size * shape / max(float(np.abs(shape).max()), 1e-300) for shape in shapes]
    columns = np.array([moved(effort) for effort in tried]).T
    lengths = np.linalg.norm(columns, axis=0)
    if not np.all(np.isfinite(columns)) or not np.any(lengths > 0.0):
        raise InputError(
            "expected an input that moves the axis, but the simulated position stays or diverges; "
            "check [inputs] and [states] of the twin file"
        )
    scaled = columns / np.where(lengths > 0.0, lengths, 1.0)
    best = np.linalg.lstsq(scaled, motion - motion[0], rcond=1e-10)[0]
    best = best / np.where(lengths > 0.0, lengths, 1.0)
    return np.asarray(np.array(tried).T @ best)
