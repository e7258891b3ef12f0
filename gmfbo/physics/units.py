"""Write units of effect parameters in the units of a twin."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gmfbo.errors import InputError, did_you_mean

_TERM = re.compile(r"([A-Za-z]+|1)(\d*)")
_PLAIN = ("s", "Hz", "1")
_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "u"))
# Units of quantities that are often small; a torque of 0.05 N m needs no prefix.
_PREFIXED = ("m", "rad", "s")


@dataclass(frozen=True)
class Units:
    """The units of one twin's port and states, as its FMU spells them.

    Attributes
    ----------
    torque : str
        Of the torque port: `N.m`, or `N` on a linear axis.
    position, velocity : str
        Of the shaft: `rad` and `rad/s`, or `m` and `m/s`.
    command, current : str
        Of the actuator command and of the current or its replacement.
    load : str
        Of the load: the torque's where a load torque is known, else the current's.
    """

    torque: str = "N.m"
    position: str = "rad"
    velocity: str = "rad/s"
    command: str = "N.m"
    current: str = "N.m"
    load: str = "N.m"

    @property
    def place(self) -> str:
        """Words for the place of a torque: on a shaft or on a linear axis."""
        return "at the motor shaft" if self.position == "rad" else "on the axis"

    @property
    def torque_word(self) -> str:
        """Word for the torque port's signal: torque on a shaft, force on a linear axis."""
        return "torque" if self.position == "rad" else "force"

    def resolve(self, expression: str) -> str:
        """Write the unit of a parameter, such as `torque/velocity`, for this twin.

        Parameters
        ----------
        expression : str
            Words torque, position, velocity, command, current, load, inertia, s, Hz and 1, with a
            power where needed (`velocity2`), and at most one `/`.

        Returns
        -------
        str
            Readable rather than reduced: `N.m/(rad/s)`, `1/rad`, `kg.m2`; `1` where all cancels.

        Raises
        ------
        InputError
            The expression has another word.
        """
        above, _, below = expression.partition("/")
        top = self._term(above)
        if not below:
            return top
        bottom = self._term(below)
        if top == bottom:
            return "1"
        return f"{_bracketed(top)}/{_enclosed(bottom)}"

    def _term(self, text: str) -> str:
        found = _TERM.fullmatch(text.strip())
        words = ("torque", "position", "velocity", "command", "current", "load", "inertia")
        if found is None or found[1] not in (*words, *_PLAIN):
            raise InputError(
                f"no unit '{text}'" + did_you_mean(text, (*words, *_PLAIN)) + "; correct the effect"
            )
        word, power = found[1], found[2]
        if word in _PLAIN:
            return word + power
        unit = self._inertia() if word == "inertia" else str(getattr(self, word))
        return re.sub("[A-Za-z]+", rf"\g<0>{power}", unit) if power else unit

    def _inertia(self) -> str:
        known = {("N.m", "rad"): "kg.m2", ("N", "m"): "kg"}
        found = known.get((self.torque, self.position))
        return found or f"{_bracketed(self.torque)}/({self.position}/s2)"


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
    if unit in _PREFIXED and value != 0.0:
        usable = [pair for pair in _PREFIXES if abs(value) >= 0.1 * pair[0]] or [_PREFIXES[-1]]
        factor, prefix = usable[0]
    words = "" if unit == "1" else f" {prefix}{unit.replace('.', ' ')}"
    return f"{number(value / factor)}{words}"


def percent(share: float) -> str:
    """Write a share as a percentage: `4.2 %`."""
    return f"{number(100.0 * share)} %"


def number(value: float) -> str:
    """Write a number with at most three digits, and an exponent only if it is needed."""
    if value == 0.0:
        return "0"
    digits = 3 if f"{abs(value):.0e}"[0] == "1" else 2
    rounded = float(f"{value:.{digits - 1}e}")
    if 1e-4 <= abs(rounded) < 1e6:
        return f"{rounded:.12f}".rstrip("0").rstrip(".")
    return f"{rounded:.{digits}g}"


def _bracketed(unit: str) -> str:
    return f"({unit})" if "/" in unit else unit


def _enclosed(unit: str) -> str:
    return f"({unit})" if "/" in unit or "." in unit else unit
