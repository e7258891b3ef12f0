"""Numbers on the page, each marked with its place in `diagnosis.json`."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from gmfbo.plain_words import percent
from gmfbo.units import SMALL

_PREFIXES = ((1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"))
_PREFIXED = ("N", "m", "rad", "s", "V", "A", "W", "Hz", "Pa")
_NO_BREAK, _THIN = "\u00a0", "\u202f"
_POWERS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")

Path = Sequence[str | int]


def json_path(path: Path) -> str:
    r"""Write a place in `diagnosis.json`: names and indices joined by dots, `\.` within a name."""
    return ".".join(str(step).replace("\\", "\\\\").replace(".", "\\.") for step in path)


def unit_text(unit: str) -> str:
    """Write a unit for reading: `kg.m2` is "kg m²"; empty for a plain number."""
    if unit in ("", "1"):
        return ""
    powers = re.sub(r"(?<=[A-Za-z])\d+", lambda found: found[0].translate(_POWERS), unit)
    return powers.replace(".", _NO_BREAK)


@dataclass(frozen=True)
class Scale:
    """A shown unit, and its size in the unit of `diagnosis.json`.

    Attributes
    ----------
    factor : float
        [unit of the JSON] Size of one shown unit.
    unit : str
        Shown, such as "mN m".
    """

    factor: float
    unit: str


def scale_for(value: float, unit: str, *, share: bool = False) -> Scale:
    """Choose the prefix with which a number reads well: 0.00032 rad is in mrad.

    Parameters
    ----------
    value : float
        [unit] Largest value shown in the unit.
    unit : str
        As an FMU spells it.
    share : bool
        Whether a plain number is a share, shown in per cent.
    """
    if share and unit in ("", "1"):
        return Scale(0.01, "%")
    first = re.match(r"[A-Za-z]+(?!\d)", unit)
    size = abs(value)
    if first is None or first[0] not in _PREFIXED or not math.isfinite(size) or size == 0.0:
        return Scale(1.0, unit_text(unit))
    least = 0.1 if first[0] in SMALL else 0.01
    if least <= size < 1e4:
        return Scale(1.0, unit_text(unit))
    for factor, prefix in _PREFIXES:
        if size >= 0.9995 * factor:
            return Scale(factor, prefix + unit_text(unit))
    return Scale(1e-6, "µ" + unit_text(unit))


def marked(path: Path, text: str, *, factor: float = 1.0, digits: int | None = None) -> str:
    """Mark a shown number with its place.

    Parameters
    ----------
    path : sequence of str or int
        Its place in `diagnosis.json`.
    text : str
        Shown text; a dash for none.
    factor : float
        Number in the JSON over the shown number; negative where the word "early" gives the
        sign.
    digits : int, optional
        Significant digits, where trailing zeros are not.
    """
    scaled = "" if factor == 1.0 else f' data-scale="{factor:.12g}"'
    rounded = "" if digits is None else f' data-digits="{digits}"'
    return f'<data data-path="{escape(json_path(path))}"{scaled}{rounded}>{escape(text)}</data>'


def marked_number(path: Path, value: float, *, factor: float = 1.0, digits: int = 3) -> str:
    """Show a number with a few significant digits, in groups of three.

    Parameters
    ----------
    path : sequence of str or int
        Its place in `diagnosis.json`.
    value : float
        As it stands there.
    factor : float
        Of one shown unit.
    digits : int
        Significant ones.
    """
    if not math.isfinite(value):
        return marked(path, "-")
    shown = value / factor
    size = abs(shown)
    if size >= 1e9 or 0.0 < size < 1e-4:
        return marked(path, f"{shown:.{digits - 1}e}", factor=factor)
    if size >= 10.0**digits:
        rounded = f"{float(f'{shown:.{digits - 1}e}'):,.0f}".replace(",", _THIN)
        return marked(path, rounded, factor=factor, digits=digits)
    return marked(path, f"{shown:.{digits}g}", factor=factor)


def marked_count(path: Path, value: int) -> str:
    """Show a whole number in full."""
    return marked(path, f"{value:,d}".replace(",", _THIN))


def marked_percent(path: Path, share: float) -> str:
    """Show a share as per cent."""
    text = percent(share)
    if text == "-":
        return marked(path, text)
    return marked(path, text.removesuffix(" %"), factor=0.01) + f"{_NO_BREAK}%"


def marked_probability(path: Path, value: float) -> str:
    """Show a probability with two decimals."""
    return marked(path, f"{value:.2f}" if math.isfinite(value) else "-")


@dataclass(frozen=True)
class MarkedInterval:
    """A value and its 95 % interval, rounded to the digits that the interval justifies.

    Attributes
    ----------
    value, low, high : str
        HTML.
    unit : str
        Shown, with its prefix.
    """

    value: str
    low: str
    high: str
    unit: str

    @property
    def text(self) -> str:
        """HTML of the three with their unit."""
        told = f"{self.value} [{self.low}, {self.high}]"
        return f"{told}{_NO_BREAK}{escape(self.unit)}" if self.unit else told


def marked_interval(path: Path, value: float, low: float, high: float, unit: str) -> MarkedInterval:
    """Show a value with its 95 % interval.

    Parameters
    ----------
    path : sequence of str or int
        Of the object that holds `value`, `low` and `high` in `diagnosis.json`.
    value, low, high : float
        [unit]
    unit : str
        As an FMU spells it.
    """
    ends = [abs(end) for end in (value, low, high) if math.isfinite(end)]
    scale = scale_for(max(ends, default=0.0), unit)
    half = 0.5 * (high - low) / scale.factor

    def shown(name: str, number: float) -> str:
        text = _rounded(number / scale.factor, half)
        return marked((*path, name), text, factor=scale.factor)

    return MarkedInterval(shown("value", value), shown("low", low), shown("high", high), scale.unit)


def _rounded(number: float, half: float) -> str:
    """Round a number by its uncertainty (rule of the Particle Data Group)."""
    if not math.isfinite(number):
        return "-"
    if not math.isfinite(half) or half <= 0.0:
        return f"{number:.4g}"
    power = math.floor(math.log10(half))
    two = half / 10.0**power < 3.55
    decimals = -power + (1 if two else 0)
    if not -6 <= decimals <= 9:
        return f"{number:.4g}"
    return f"{number:.{max(decimals, 0)}f}"
