"""Numbers and names of a diagnosis in words."""

from __future__ import annotations

import math

NOT_EXCITED = "not excited"
_MOST_DIGITS = 7


def words(name: str) -> str:
    """Name of a signal or an effect as words: `torque_command` is "torque command"."""
    return name.replace("_", " ")


def number(value: float, digits: int = 3) -> str:
    """Number with a few significant digits; a dash where there is none."""
    return f"{value:.{digits}g}" if math.isfinite(value) else "-"


def percent(share: float) -> str:
    """Share as per cent, two significant digits, whole ones in full: 0.306 is "31 %"."""
    if not math.isfinite(share):
        return "-"
    return f"{100.0 * share:.0f} %" if abs(share) >= 0.0995 else f"{100.0 * share:#.2g} %"


def unit_words(unit: str) -> str:
    """Unit for reading: `N.m` is "N m", `kg.m2` is "kg m2"; empty for a plain number."""
    return "" if unit in ("", "1") else unit.replace(".", " ")


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """Value with its unit."""
    return f"{number(value, digits)} {unit_words(unit)}".rstrip()


def interval(value: float, low: float, high: float, unit: str, digits: int = 3) -> str:
    """Value with its 95 % interval and its unit: "0.52 [0.49, 0.55] N m".

    It has the digits needed to see the interval's width.
    """
    if not (math.isfinite(low) and math.isfinite(high)):
        return quantity(value, unit, digits)
    while digits < _MOST_DIGITS and low < high and number(low, digits) == number(high, digits):
        digits += 1
    ends = f"[{number(low, digits)}, {number(high, digits)}]"
    return f"{number(value, digits)} {ends} {unit_words(unit)}".rstrip()


def probability(value: float) -> str:
    """Probability with two decimals."""
    return f"{value:.2f}" if math.isfinite(value) else "-"
