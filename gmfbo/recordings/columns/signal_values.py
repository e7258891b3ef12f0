"""A recorded column's values in SI units."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.units import parse_unit

if TYPE_CHECKING:
    from gmfbo.recordings.columns.signal import SignalSpec


def plain_values(values: NDArray[np.float64], unit: str) -> tuple[NDArray[np.float64], str]:
    """Convert values by the header's unit; unknown units and counts stay unchanged.

    Parameters
    ----------
    values : ndarray, shape (n,)
        In the unit of the header.
    unit : str
        As written; empty where none is.

    Returns
    -------
    values : ndarray, shape (n,)
        In the unit returned.
    unit : str
        SI unit, or the text as it was.
    """
    known = parse_unit(unit) if unit else None
    if known is None:
        return values, unit.strip()
    return known.to_si(values), known.si


def signal_values(
    values: NDArray[np.float64], unit: str, spec: SignalSpec, *, already_scaled: bool = False
) -> tuple[NDArray[np.float64], str]:
    """Values of a signal that the twin names: scale * column + offset.

    Parameters
    ----------
    values : ndarray, shape (n,)
        As recorded.
    unit : str
        As written; empty where none is, then taken for SI.
    spec : SignalSpec
        Scale, offset and SI unit.
    already_scaled : bool
        Whether the file holds the signal itself, so that scale and offset do not apply.

    Returns
    -------
    values : ndarray, shape (n,)
        In SI.
    unit : str
        SI unit; empty where neither header nor FMU states one.

    Raises
    ------
    RecordingError
        The header's unit is unknown, is not the signal's, or needs a scale.
    """
    target = parse_unit(spec.unit) if spec.unit else None
    si = target.si if target is not None else spec.unit
    if spec.scaled and not already_scaled:
        return values * spec.scale + spec.offset, si
    offset = 0.0 if already_scaled else spec.offset
    if not unit or unit == spec.unit == si:
        return (values + offset if offset else values), si
    known = parse_unit(unit)
    if known is None:
        raise RecordingError(
            f"unit [{unit}] of signal '{spec.name}' is not known, expected "
            f"{_expected(si)}; correct it, or give 'scale' in the twin file"
        )
    if known.needs_scale and (target is None or not target.needs_scale):
        raise RecordingError(
            f"[{unit}] of signal '{spec.name}' have no SI value of their own, expected "
            f"{_expected(si)}; give 'scale' ({_expected(si, 'SI unit')} per count) in the twin file"
        )
    if target is not None and known.dimension != target.dimension:
        raise RecordingError(
            f"expected [{si}] or a multiple for signal '{spec.name}', got [{unit}]; correct the "
            "unit, or give 'scale' in the twin file"
        )
    converted = known.to_si(values)
    return (converted + offset if offset else converted), si or known.si


def _expected(si: str, otherwise: str = "a known unit") -> str:
    return f"[{si}]" if si else otherwise
