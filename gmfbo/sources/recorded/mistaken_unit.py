"""Units that a column may really be in, by how many times too large its values are."""

from __future__ import annotations

import math

from gmfbo.units import parse_unit

_COMMON = ("deg", "rev", "deg/s", "rpm", "rev/s", "mm", "cm", "in", "mm/s", "m/min")

AXIS_GAIN = 1.3
"""Factor by which a right column may differ from a twin that follows the same reference.

The largest of the library's effects, a wrong scale of the sensor, makes 1 / 0.77.
"""


def mistaken_unit(unit: str, gain: float) -> str | None:
    """Unit in which values are this many times those in SI; None where no known unit is near.

    A gain counts for the unit that is nearest by its logarithm, and for the right one if that is
    nearest of all.

    Parameters
    ----------
    unit : str
        SI unit in which the values were expected.
    gain : float
        Size of the values over what was expected [1].
    """
    if not gain or not math.isfinite(gain):
        return None
    found = {name: times_si(name) for name in known_units(unit)}
    away = {name: abs(math.log(abs(gain) / ratio)) for name, ratio in found.items()}
    nearest = min(away, key=lambda name: away[name], default=None)
    if nearest is None or away[nearest] > math.log(AXIS_GAIN):
        return None
    return nearest if away[nearest] < abs(math.log(abs(gain))) else None


def known_units(unit: str) -> list[str]:
    """Usual units of the quantity of an SI unit, which they are not.

    Parameters
    ----------
    unit : str
        SI unit; empty where it is not known.
    """
    expected = parse_unit(unit) if unit else None
    if expected is None:
        return []
    names = [*_COMMON, *(f"{prefix}{unit}" for prefix in ("m", "k"))]
    known = {name: parse_unit(name) for name in names}
    return [
        name
        for name, own in known.items()
        if own is not None and own.dimension == expected.dimension and not own.zero
    ]


def times_si(unit: str) -> float:
    """How many times the SI value a value in this unit is [1].

    Parameters
    ----------
    unit : str
        A unit that is known.
    """
    known = parse_unit(unit)
    assert known is not None, "one of the candidates"
    return 1.0 / (float(known.factor) * math.pi**known.pi)
