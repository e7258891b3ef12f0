"""Units as people write them, what they are in SI, and numbers with their unit for a sentence.

`Nm`, `N m`, `N.m` and `N·m` are one unit; `rpm`, `deg/s` and `mm` are converted. The angle has a
dimension of its own, so that a column in `1/s` or `Hz` is never taken for `rad/s`.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

# Exponents of kg, m, s, A, K, rad and counts.
Dimension = tuple[int, int, int, int, int, int, int]
_NONE: Dimension = (0, 0, 0, 0, 0, 0, 0)

# The coherent SI units, by the symbol that gmfbo writes.
_SI: dict[str, Dimension] = {
    "1": _NONE,
    "kg": (1, 0, 0, 0, 0, 0, 0),
    "m": (0, 1, 0, 0, 0, 0, 0),
    "s": (0, 0, 1, 0, 0, 0, 0),
    "A": (0, 0, 0, 1, 0, 0, 0),
    "K": (0, 0, 0, 0, 1, 0, 0),
    "rad": (0, 0, 0, 0, 0, 1, 0),
    "counts": (0, 0, 0, 0, 0, 0, 1),
    "N": (1, 1, -2, 0, 0, 0, 0),
    "J": (1, 2, -2, 0, 0, 0, 0),
    "W": (1, 2, -3, 0, 0, 0, 0),
    "Pa": (1, -1, -2, 0, 0, 0, 0),
    "C": (0, 0, 1, 1, 0, 0, 0),
    "V": (1, 2, -3, -1, 0, 0, 0),
    "ohm": (1, 2, -3, -2, 0, 0, 0),
    "S": (-1, -2, 3, 2, 0, 0, 0),
    "F": (-1, -2, 4, 2, 0, 0, 0),
    "H": (1, 2, -2, -2, 0, 0, 0),
    "Wb": (1, 2, -2, -1, 0, 0, 0),
    "T": (1, 0, -2, -1, 0, 0, 0),
    "Hz": (0, 0, -1, 0, 0, 0, 0),
}

# Other symbols: rational factor, whether pi multiplies it, and the SI expression.
_OTHER: dict[str, tuple[Fraction, bool, str]] = {
    "g": (Fraction(1, 1000), False, "kg"),
    "Nm": (Fraction(1), False, "N.m"),
    "Ncm": (Fraction(1, 100), False, "N.m"),
    "Nmm": (Fraction(1, 1000), False, "N.m"),
    "deg": (Fraction(1, 180), True, "rad"),
    "rev": (Fraction(2), True, "rad"),
    "gon": (Fraction(1, 200), True, "rad"),
    "rpm": (Fraction(1, 30), True, "rad/s"),
    "dps": (Fraction(1, 180), True, "rad/s"),
    "arcmin": (Fraction(1, 180 * 60), True, "rad"),
    "arcsec": (Fraction(1, 180 * 3600), True, "rad"),
    "min": (Fraction(60), False, "s"),
    "h": (Fraction(3600), False, "s"),
    "d": (Fraction(86400), False, "s"),
    "%": (Fraction(1, 100), False, "1"),
    "‰": (Fraction(1, 1000), False, "1"),
    "ppm": (Fraction(1, 10**6), False, "1"),
    "bar": (Fraction(10**5), False, "Pa"),
    "in": (Fraction(254, 10000), False, "m"),
    "ft": (Fraction(3048, 10000), False, "m"),
    "lbf": (Fraction("4.4482216152605"), False, "N"),
}
_NO_PREFIX = {
    "1", "kg", "counts", "min", "h", "d", "%", "‰", "ppm", "in", "ft", "lbf", "Ncm", "Nmm",
}  # fmt: skip

# No peta: `PS` means horse power, not petasiemens.
_PREFIXES: dict[str, Fraction] = {
    "T": Fraction(10**12),
    "G": Fraction(10**9),
    "M": Fraction(10**6),
    "k": Fraction(1000),
    "h": Fraction(100),
    "da": Fraction(10),
    "d": Fraction(1, 10),
    "c": Fraction(1, 100),
    "m": Fraction(1, 1000),
    "u": Fraction(1, 10**6),
    "n": Fraction(1, 10**9),
    "p": Fraction(1, 10**12),
    "f": Fraction(1, 10**15),
}

SMALL = ("m", "rad", "s")
"""Units in which small numbers are the rule; a torque of 0.05 N m needs no prefix."""

_ALIASES: dict[str, str] = {
    "-": "1", "one": "1", "pu": "1", "ratio": "1",
    "pct": "%", "percent": "%", "permille": "‰", "promille": "‰",
    "count": "counts", "cnt": "counts", "cnts": "counts", "inc": "counts", "incs": "counts",
    "increment": "counts", "increments": "counts", "tick": "counts", "ticks": "counts",
    "lsb": "counts", "digit": "counts", "digits": "counts",
    "°": "deg", "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad",
    "turn": "rev", "turns": "rev", "revs": "rev", "U": "rev", "r": "rev", "RPM": "rpm",
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us",
    "minute": "min", "minutes": "min", "hr": "h", "hour": "h", "hours": "h",
    "day": "d", "days": "d",
    "Ω": "ohm", "Ohm": "ohm", "Ohms": "ohm", "ohms": "ohm", "inch": "in",
    "meter": "m", "metre": "m", "meters": "m", "metres": "m",
    "volt": "V", "volts": "V", "Volt": "V", "Volts": "V",
    "amp": "A", "amps": "A", "Amp": "A", "Amps": "A", "ampere": "A", "amperes": "A",
    "NM": "Nm", "newton": "N", "newtons": "N", "hertz": "Hz", "watt": "W", "watts": "W",
    # German; without its own entry `Grad` would be a gigaradian, and so would `Gradian`.
    "Grad": "deg", "umdrehung": "rev", "umdrehungen": "rev", "umdr": "rev", "Umdr": "rev",
    "sekunde": "s", "sekunden": "s", "newtonmeter": "Nm",
    "gradian": "gon", "gradians": "gon", "Gradian": "gon", "Gradians": "gon",
    "kelvin": "K", "joule": "J", "joules": "J", "pascal": "Pa", "pascals": "Pa",
}  # fmt: skip

_PREFIX_WORDS = {
    "nano": "n",
    "micro": "u",
    "mikro": "u",
    "milli": "m",
    "centi": "c",
    "kilo": "k",
    "mega": "M",
}

# From three letters on no other unit differs from these only by capitals.
_WORDS = {
    word.lower(): word
    for word in (*_SI, *_OTHER, *_ALIASES)
    if len(word) > 2 and word.isascii() and word.isalpha() and word == word.lower()
}

# Temperatures, the only units with an offset: factor, and kelvins at zero.
_TEMPERATURES = {
    **dict.fromkeys(("degC", "°C", "celsius", "Celsius", "deg C"), (Fraction(1), 273.15)),
    **dict.fromkeys(("degF", "°F"), (Fraction(5, 9), 459.67 * 5 / 9)),
}

_SPELLING = str.maketrans(
    {"·": ".", "⋅": ".", "×": ".", "*": ".", "²": "2", "³": "3", "⁻": "-", "¹": "1", "^": None}
    | {"µ": "u", "μ": "u", "\N{OHM SIGN}": "Ω"}
)
_TOKEN = re.compile(r"\s*([()./]|[+-]?\d+|[^\s()./\d+-]+|-)")


@dataclass(frozen=True)
class Unit:
    """A unit and its conversion to SI: value_SI = value * factor * (pi) + zero.

    Attributes
    ----------
    si : str
        SI unit in gmfbo's spelling: `N.m`, `rad/s`, `kg.m2`; `1` where there is none.
    factor : Fraction
        Rational part of the factor [si / unit].
    pi : int
        Power of pi in the factor: 1 for deg, rev and rpm, -1 where they divide.
    zero : float
        SI value of zero [si]; not 0 for temperatures only.
    dimension : tuple of int
        Exponents of kg, m, s, A, K, rad and counts.
    """

    si: str
    factor: Fraction
    pi: int
    zero: float
    dimension: Dimension

    @property
    def is_si(self) -> bool:
        """Whether values need no conversion."""
        return self.factor == 1 and self.pi == 0 and self.zero == 0.0

    @property
    def needs_scale(self) -> bool:
        """Whether the unit is counts of an encoder or converter, which need a scale."""
        return self.dimension[6] != 0

    def to_si(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert values, any shape, to SI; milli is a division, so that 3 ms is exactly 0.003."""
        if self.is_si:
            return values
        scaled = values * float(self.factor.numerator) / float(self.factor.denominator)
        if self.pi:
            scaled = scaled * math.pi**self.pi
        return scaled + self.zero if self.zero else scaled


def parse_unit(text: str) -> Unit | None:
    """Parse a unit such as `mNm`, `deg/s`, `kg.m^2`, `N m/(rad/s)`, `per mille`.

    Parameters
    ----------
    text : str
        As it stands in a header's brackets or an FMU.

    Returns
    -------
    Unit or None
        None where the text is no known unit.
    """
    return _parse_unit(text.strip())


@lru_cache(maxsize=512)
def _parse_unit(text: str) -> Unit | None:
    if text in _TEMPERATURES:
        factor, zero = _TEMPERATURES[text]
        return Unit("K", factor, 0, zero, _SI["K"])
    plain = text.translate(_SPELLING).replace("per mille", "‰").replace("per cent", "%")
    tokens = _TOKEN.findall(plain)
    if not tokens or "".join(tokens) != re.sub(r"\s", "", plain):
        return None
    product = _Product()
    rest = _read_product(tokens, 1, product)
    if rest is None or rest:
        return None
    return Unit(product.spelling(), product.factor, product.pi, 0.0, product.dimension())


def si_spelling(dimension: Dimension) -> str:
    """SI unit of a dimension: the name that is usual in mechanics, else powers of base units.

    Parameters
    ----------
    dimension : tuple of int
        Exponents of kg, m, s, A, K, rad and counts.
    """
    if dimension == _SI["J"]:
        return "N.m"
    named = next((symbol for symbol, own in _SI.items() if own == dimension), "")
    if named:
        return named
    product = _Product()
    for symbol, power in zip(("kg", "m", "s", "A", "K", "rad", "counts"), dimension, strict=True):
        product.multiply(symbol, power)
    return product.spelling()


class _Product:
    """Powers of SI symbols with a factor, accumulated while an expression is read."""

    def __init__(self) -> None:
        self.factor = Fraction(1)
        self.pi = 0
        self.powers: dict[str, int] = {}

    def multiply(self, symbol: str, power: int) -> bool:
        """Multiply by symbol**power; False where the symbol is not known."""
        found = _symbol(symbol)
        if found is None:
            return False
        factor, has_pi, expression = found
        self.factor *= factor**power
        self.pi += power * has_pi
        numerator, _, denominator = expression.partition("/")
        for part in numerator.split("."):
            self.powers[part] = self.powers.get(part, 0) + power
        if denominator:
            self.powers[denominator] = self.powers.get(denominator, 0) - power
        return True

    def spelling(self) -> str:
        above = [_power(s, p) for s, p in self.powers.items() if p > 0 and s != "1"]
        below = [_power(s, -p) for s, p in self.powers.items() if p < 0 and s != "1"]
        if not below:
            return ".".join(above) or "1"
        bottom = below[0] if len(below) == 1 else f"({'.'.join(below)})"
        return f"{'.'.join(above) or '1'}/{bottom}"

    def dimension(self) -> Dimension:
        total = list(_NONE)
        for symbol, power in self.powers.items():
            for place, exponent in enumerate(_SI[symbol]):
                total[place] += exponent * power
        kg, m, s, a, k, rad, counts = total
        return (kg, m, s, a, k, rad, counts)


def _power(symbol: str, power: int) -> str:
    return symbol if power == 1 else f"{symbol}{power}"


def _symbol(symbol: str) -> tuple[Fraction, bool, str] | None:
    """Factor, whether pi multiplies it, and SI expression of one symbol."""
    symbol = _ALIASES.get(symbol, symbol)
    if symbol in _SI:
        return Fraction(1), False, symbol
    if symbol in _OTHER:
        return _OTHER[symbol]
    for length in (2, 1):
        prefix, rest = _PREFIXES.get(symbol[:length]), symbol[length:]
        rest = _ALIASES.get(rest, rest)
        if prefix is None or rest in _NO_PREFIX:
            continue
        if rest in _SI:
            return prefix, False, rest
        if rest in _OTHER:
            factor, has_pi, expression = _OTHER[rest]
            return prefix * factor, has_pi, expression
    return _spelled_out(symbol)


def _spelled_out(symbol: str) -> tuple[Fraction, bool, str] | None:
    """A unit in words, with any capitals: `Milliseconds`, `Deg`."""
    word, factor = symbol.lower(), Fraction(1)
    for spelled, prefix in _PREFIX_WORDS.items():
        if word.startswith(spelled):
            word, factor = word.removeprefix(spelled), _PREFIXES[prefix]
    if word not in _WORDS or (word == symbol and factor == 1):
        return None
    found = _symbol(_WORDS[word])
    return None if found is None else (factor * found[0], *found[1:])


def _read_product(tokens: list[str], sign: int, product: _Product) -> list[str] | None:
    """Read factors up to a closing bracket; returns the remaining tokens, or None for no unit."""
    direction = sign
    expect_factor = True
    while tokens and tokens[0] != ")":
        token, tokens = tokens[0], tokens[1:]
        if token in "./":
            if expect_factor:
                return None
            direction = -sign if token == "/" else sign
            expect_factor = True
        elif token == "(":
            inner = _read_product(tokens, direction, product)
            if not inner:  # no unit, or the closing bracket is missing
                return None
            tokens, direction, expect_factor = inner[1:], sign, False
        else:
            power = 1
            if tokens and re.fullmatch(r"[+-]?\d+", tokens[0]) and token != "1":
                power, tokens = int(tokens[0]), tokens[1:]
            if abs(power) > 9 or not product.multiply(token, direction * power):
                return None
            direction, expect_factor = sign, False
    return None if expect_factor else tokens


def unit_words(unit: str) -> str:
    """Unit as it is read: `N.m` is "N m", `kg.m2` is "kg m2"; none for a plain number."""
    return "" if unit in ("", "1") else unit.replace(".", " ")


def quantity(value: float, unit: str) -> str:
    """Write a number with its unit for a sentence: `0.52 N m`, `1.3 ms`.

    Parameters
    ----------
    value : float
        In `unit`.
    unit : str
        As `Units.resolve` gives it; dots become blanks.

    Returns
    -------
    str
        Two or three significant digits, with a prefix where the number is small.
    """
    factor, prefix = 1.0, ""
    if unit in SMALL and abs(value) < 0.1 and value != 0.0:
        factor, prefix = (1e-3, "m") if abs(value) >= 1e-4 else (1e-6, "u")
    words = "" if unit == "1" else f" {prefix}{unit_words(unit)}"
    return f"{number(value / factor)}{words}"


def percent(share: float) -> str:
    """Write a share as a percentage: `4.2 %`."""
    return f"{number(100.0 * share)} %"


def number(value: float) -> str:
    """Write a number as a person would: three digits at most, no exponent unless it is needed."""
    if value == 0.0:
        return "0"
    digits = 3 if f"{abs(value):.0e}"[0] == "1" else 2
    rounded = float(f"{value:.{digits - 1}e}")
    if 1e-4 <= abs(rounded) < 1e6:
        return f"{rounded:.12f}".rstrip("0").rstrip(".")
    return f"{rounded:.{digits}g}"
