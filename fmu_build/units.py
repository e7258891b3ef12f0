"""Unit expressions such as `N.m/(rad/s)` as powers of the SI base units."""

from __future__ import annotations

import re
from dataclasses import dataclass

from fmu_build.failure import BuildError

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Unit:
    """Factor to SI and the power of each of `BASE_UNITS`."""

    factor: float
    powers: tuple[int, ...]

    def times(self, other: Unit, power: int = 1) -> Unit:
        """Product of this unit with a power of another."""
        powers = tuple(a + power * b for a, b in zip(self.powers, other.powers, strict=True))
        return Unit(self.factor * other.factor**power, powers)


def _unit(factor: float = 1.0, **powers: int) -> Unit:
    return Unit(factor, tuple(powers.get(base, 0) for base in BASE_UNITS))


UNITS = {
    "1": _unit(),
    "%": _unit(0.01),
    "count": _unit(),
    "rad": _unit(rad=1),
    "kg": _unit(kg=1),
    "m": _unit(m=1),
    "mm": _unit(1e-3, m=1),
    "s": _unit(s=1),
    "ms": _unit(1e-3, s=1),
    "Hz": _unit(s=-1),
    "A": _unit(A=1),
    "K": _unit(K=1),
    "N": _unit(kg=1, m=1, s=-2),
    "Pa": _unit(kg=1, m=-1, s=-2),
    "J": _unit(kg=1, m=2, s=-2),
    "W": _unit(kg=1, m=2, s=-3),
    "V": _unit(kg=1, m=2, s=-3, A=-1),
    "Ohm": _unit(kg=1, m=2, s=-3, A=-2),
    "Wb": _unit(kg=1, m=2, s=-2, A=-1),
    "H": _unit(kg=1, m=2, s=-2, A=-2),
    "F": _unit(kg=-1, m=-2, s=4, A=2),
}
_TOKEN = re.compile(r"([A-Za-z%]+|1(?![0-9]))(-?[0-9]+)?|([./()])")


def parse_unit(text: str) -> Unit:
    """Read products with `.`, quotients with `/` and powers written as trailing integers.

    Parameters
    ----------
    text : str
        For example `kg.m2`, `rad/s2` or `V/(m/s)`.

    Returns
    -------
    Unit
        Factor and powers.

    Raises
    ------
    BuildError
        For an unknown unit or an expression with two readings, such as `a/b.c`.
    """
    unit, end = _product(text, 0)
    if end != len(text):
        raise BuildError(f"unit '{text}': cannot read '{text[end:]}'")
    return unit


def _product(text: str, start: int) -> tuple[Unit, int]:
    unit, position = _factor(text, start)
    divided = False
    while position < len(text) and text[position] in "./":
        if divided:
            raise BuildError(f"unit '{text}': put the denominator in parentheses, as in a/(b.c)")
        divided = text[position] == "/"
        factor, position = _factor(text, position + 1)
        unit = unit.times(factor, -1 if divided else 1)
    return unit, position


def _factor(text: str, start: int) -> tuple[Unit, int]:
    token = _TOKEN.match(text, start)
    if token is None:
        raise BuildError(f"unit '{text}': expected a unit at '{text[start:]}'")
    if token[0] == "(":
        unit, position = _product(text, token.end())
        if text[position : position + 1] != ")":
            raise BuildError(f"unit '{text}': a parenthesis is not closed")
        return unit, position + 1
    if token[1] not in UNITS:
        raise BuildError(f"unit '{text}': '{token[1] or token[0]}' is unknown; add it to units.py")
    return _unit().times(UNITS[token[1]], int(token[2] or 1)), token.end()
