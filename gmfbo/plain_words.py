"""Numbers and names of a diagnosis in words."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable

from gmfbo.units import unit_words

NOT_EXCITED = "not excited"
WIDTH = 79
"""[characters] Widest line on a terminal."""

_MOST_DIGITS = 7
_TWO_MINUTES = 120  # [s] Up to there seconds alone are read with ease.


def words(name: str) -> str:
    """Name of a signal or an effect as words: `torque_command` is "torque command".

    A parameter of the twin keeps its name: `parameter:plant.filter_time` is "parameter
    plant.filter_time".
    """
    kind, _, own = name.partition("parameter:")
    return f"{words(kind)}parameter {own}" if own else name.replace("_", " ")


def number(value: float, digits: int = 3) -> str:
    """Number with a few significant digits; a dash where there is none."""
    return f"{value:.{digits}g}" if math.isfinite(value) else "-"


def percent(share: float) -> str:
    """Share as per cent, two significant digits, whole ones in full: 0.306 is "31 %"."""
    if not math.isfinite(share):
        return "-"
    return f"{100.0 * share:.0f} %" if abs(share) >= 0.0995 else f"{100.0 * share:#.2g} %"


def listed(entries: Iterable[str]) -> str:
    """Entries with commas and "and": "a, b and c"."""
    *before, last = entries
    return f"{', '.join(before)} and {last}" if before else last


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """Value with its unit."""
    return f"{number(value, digits)} {unit_words(unit)}".rstrip()


def duration(seconds: float) -> str:
    """Time as a person writes it: "250 us", "1.2 ms", "8.18 s", "2 min 5 s", "3 h 20 min".

    Up to two minutes it has three significant digits.
    """
    if not math.isfinite(seconds):
        return "-"
    size = abs(float(f"{seconds:.3g}"))  # rounded first: 0.9996 s is 1 s, not 1e+03 ms
    sign = "-" if seconds < 0.0 else ""
    if size == 0.0 or 1.0 <= size < _TWO_MINUTES:
        return f"{sign}{number(size)} s"
    if size < 1.0:
        factor, unit = (1e3, "ms") if size >= 1e-3 else (1e6, "us")
        return f"{sign}{number(factor * size)} {unit}"
    minutes, left = divmod(round(abs(seconds)), 60)
    if minutes < 60:
        return f"{sign}{minutes} min {left} s" if left else f"{sign}{minutes} min"
    hours, left = divmod(round(abs(seconds) / 60.0), 60)
    return f"{sign}{hours} h {left} min" if left else f"{sign}{hours} h"


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


def time_left(seconds: float) -> str:
    """Say a time to come as roughly as it is known: seconds, minutes or hours.

    Parameters
    ----------
    seconds : float
        [s] At least 0.
    """
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 90.0 * 60.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"


def probability(value: float) -> str:
    """Probability with two decimals."""
    return f"{value:.2f}" if math.isfinite(value) else "-"


def wrapped(text: str, head: str, most: int | None = None) -> list[str]:
    """Lines of a text behind a head, whose width later lines leave free; no word is cut.

    Of more than `most` lines the last ends in dots.
    """
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=head,
        subsequent_indent=" " * len(head),
        break_long_words=False,
        break_on_hyphens=False,
        max_lines=most,
        placeholder=" ...",
    )
