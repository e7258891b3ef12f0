"""What a unit of an FMU is in SI: by the FMU's own definition, then by gmfbo's table."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from gmfbo.sources.fmu_file.numbers import number_from
from gmfbo.units import Dimension, parse_unit, si_spelling

_EXPONENTS = ("kg", "m", "s", "A", "K", "rad")
_OTHER = ("mol", "cd")
_RAD = _EXPONENTS.index("rad")

_ROUNDED = 1e-3
"""Share by which a factor in an FMU may be rounded; no two units of one dimension are as near."""


class FmuUnit(NamedTuple):
    """A unit in SI: value in SI = value * factor + zero.

    Attributes
    ----------
    si : str
        SI unit in gmfbo's spelling; the FMU's own name where nothing is known of it.
    factor, zero : float
        Conversion.
    """

    si: str
    factor: float = 1.0
    zero: float = 0.0


class _Stated(NamedTuple):
    dimension: Dimension
    factor: float
    zero: float


def fmu_unit(name: str, base: Any) -> FmuUnit:
    """Convert a unit by the FMU's definition; by the table where that says nothing else.

    Many FMUs leave out definitions, or the angle in them: `rad/s` as `s=-1`. A definition that
    agrees with the table but for that is the table's unit.

    Parameters
    ----------
    name : str
        As the FMU writes it; empty where a variable has none.
    base : fmpy.model_description.BaseUnit or None
        The FMU's definition.
    """
    known = parse_unit(name) if name else None
    stated = _stated(base)
    if known is None or known.needs_scale:
        if stated is not None and name:
            return FmuUnit(si_spelling(stated.dimension), stated.factor, stated.zero)
        factor, zero = _conversion(base)
        return FmuUnit(name, factor, zero)
    ends = known.to_si(np.array([0.0, 1.0]))
    own = _Stated(known.dimension, float(ends[1] - ends[0]), float(ends[0]))
    if stated is None or _agree(own, stated):
        return FmuUnit(known.si, own.factor, own.zero)
    return FmuUnit(si_spelling(stated.dimension), stated.factor, stated.zero)


def _stated(base: Any) -> _Stated | None:
    """Definition of a unit; None where there is none that says more than "a number"."""
    if base is None or any(number_from(getattr(base, one, 0)) for one in _OTHER):
        return None
    kg, m, s, a, k, rad = (int(number_from(getattr(base, one, 0)) or 0) for one in _EXPONENTS)
    factor, zero = _conversion(base)
    if not any((kg, m, s, a, k, rad)) and (factor, zero) == (1.0, 0.0):
        return None
    return _Stated((kg, m, s, a, k, rad, 0), factor, zero)


def _conversion(base: Any) -> tuple[float, float]:
    factor, zero = (number_from(getattr(base, key, None)) for key in ("factor", "offset"))
    return factor or 1.0, zero or 0.0


def _agree(own: _Stated, stated: _Stated) -> bool:
    """Whether a definition is the table's unit, perhaps without its angle or in full turns."""
    angle = own.dimension[_RAD]
    silent = angle != 0 and stated.dimension[_RAD] == 0
    bare = tuple(0 if place == _RAD and silent else e for place, e in enumerate(own.dimension))
    if bare != stated.dimension or abs(own.zero - stated.zero) > _ROUNDED * (1.0 + abs(own.zero)):
        return False
    ratios = [1.0, (2.0 * math.pi) ** angle] if silent else [1.0]
    return any(
        math.isclose(own.factor, ratio * stated.factor, rel_tol=_ROUNDED) for ratio in ratios
    )
