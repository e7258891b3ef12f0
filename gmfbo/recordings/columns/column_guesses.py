"""Guess which column of a logger's file is which signal, by words in its name and by its unit."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from gmfbo.recordings.columns.columns import Column, last_part
from gmfbo.recordings.columns.signal import SignalSpec
from gmfbo.recordings.columns.unit_in_name import names_and_units
from gmfbo.units import Dimension, parse_unit

_ROLES = {
    "reference": "ref reference set setpoint setvalue sp cmd command commanded target des desired "
    "demand soll sollwert goal input",
    "measured": "act actual ist istwert meas measured feedback fb fbk est estimate estimated enc "
    "encoder",
}
_QUANTITIES = {
    "position": "pos position angle phi theta winkel lage weg stellung q enc encoder",
    "velocity": "vel velocity velo speed omega w drehzahl geschwindigkeit dq",
    "force": "torque trq tau moment drehmoment force kraft",
    "current": "current iq strom amps",
    "voltage": "voltage volt spannung vbus",
    "temperature": "temp temperature temperatur",
}
_UNITS = {
    "position": ("rad", "m"),
    "velocity": ("rad/s", "m/s"),
    "force": ("N.m", "N"),
    "current": ("A",),
    "voltage": ("V",),
    "temperature": ("K",),
}
_ROLE_OF = {word: role for role, words in _ROLES.items() for word in words.split()}
_QUANTITY_OF = {word: name for name, words in _QUANTITIES.items() for word in words.split()}
_MOTIONS = ("position", "velocity")

_SAME_NAME, _SAME_ROLE, _SAME_QUANTITY, _LIKE = 4, 3, 2, 1
"""How far a column fits, best first: its name is the signal's own; it is the same quantity, and
commanded or measured as the signal is; it is the same quantity; it shares a word."""

_WORD = re.compile(r"[A-ZÄÖÜ]+(?![a-zäöü])|[A-ZÄÖÜ]?[a-zäöü]+|\d+")
_COMPOUND = re.compile(r"(soll|ist)(?P<first>.+)|(?P<last>.+)(soll|sollwert|ist|istwert)")


@dataclass(frozen=True)
class ColumnGuess:
    """Columns that may be a signal.

    Attributes
    ----------
    columns : tuple of str
        The likeliest ones in the order of the file: one is a guess, several are a question.
    same_name : bool
        Whether they have the signal's own name.
    """

    columns: tuple[str, ...]
    same_name: bool


@dataclass(frozen=True)
class _Meaning:
    """Quantity and role that a name and a unit tell, empty where they do not; and all words."""

    quantity: str
    role: str
    words: frozenset[str]


def guess_columns(
    specs: Mapping[str, SignalSpec],
    columns: Sequence[Column],
    aliases: Mapping[str, Sequence[str]] | None = None,
) -> dict[str, ColumnGuess]:
    """Guess the columns of signals.

    Parameters
    ----------
    specs : mapping of str to SignalSpec
        Signals to find, by name; where two fit a column as well, the first gets it.
    columns : sequence of Column
        Columns that may be guessed.
    aliases : mapping of str to sequence of str, optional
        Other names of a signal, such as that of its FMU variable.

    Returns
    -------
    dict of str to ColumnGuess
        By signal; without those for which no column is likely.
    """
    fits = {
        name: {c.name: _fit(spec, (name, *(aliases or {}).get(name, ())), c) for c in columns}
        for name, spec in specs.items()
    }
    found: dict[str, ColumnGuess] = {}
    taken: set[str] = set()
    for level in (_SAME_NAME, _SAME_ROLE, _SAME_QUANTITY, _LIKE):
        for name in specs:
            likely = tuple(c for c, fit in fits[name].items() if fit == level and c not in taken)
            if name not in found and likely:
                found[name] = ColumnGuess(likely, level == _SAME_NAME)
                taken |= {*likely} if len(likely) == 1 else set()
    return {
        name: ColumnGuess(left, guess.same_name)
        for name, guess in found.items()
        if (left := _left(guess, taken))
    }


def _left(guess: ColumnGuess, taken: set[str]) -> tuple[str, ...]:
    """Columns of a question that no other signal got; a guess keeps its column."""
    if len(guess.columns) == 1:
        return guess.columns
    return tuple(column for column in guess.columns if column not in taken)


def quantity_of_unit(unit: str) -> str:
    """Quantity of a unit.

    Parameters
    ----------
    unit : str
        As it stands in a header or an FMU.

    Returns
    -------
    str
        `position`, `velocity`, `force`, `current`, `voltage`, `temperature`; else empty.
    """
    known = parse_unit(unit) if unit else None
    return "" if known is None else _QUANTITY_OF_DIMENSION.get(known.dimension, "")


def name_and_unit(column: Column) -> tuple[str, str]:
    """Name of a column and its unit, from its header or else from the end of its name."""
    if column.unit:
        return column.name, column.unit
    return next(names_and_units(column.name), (column.name, ""))


def _fit(spec: SignalSpec, names: Sequence[str], column: Column) -> int:
    """How far a column fits a signal: a level from above, 0 where it cannot be it."""
    name, unit = name_and_unit(column)
    if _contradict(unit, spec.unit):
        return 0
    own = {_letters(one) for one in names}
    if own & {_letters(name), _letters(last_part(name)), _letters(column.name)}:
        return _SAME_NAME
    told, asked = _told(name, unit), _asked(spec, names)
    if _names_another(told) or _is_other_role(told, asked, spec.driven):
        return 0
    same_role = told.role == asked.role != ""
    # "Sollwert" and "Istwert" are those of the loop, whatever is controlled in it.
    unsaid = same_role and not told.quantity and (spec.driven or asked.quantity == "position")
    if asked.quantity and (told.quantity == asked.quantity or unsaid):
        return _SAME_ROLE if same_role else _SAME_QUANTITY
    if told.quantity and asked.quantity:
        return 0
    return _LIKE if _share_a_word(told.words, asked.words) else 0


def _names_another(told: _Meaning) -> bool:
    """Whether a name says another quantity than the unit; single letters say too little."""
    said = {_QUANTITY_OF[word] for word in told.words if word in _QUANTITY_OF and len(word) > 2}
    return bool(said) and told.quantity not in said


def _is_other_role(told: _Meaning, asked: _Meaning, driven: bool) -> bool:
    """Whether a motion is commanded where a measured one is asked for, or the reverse."""
    if asked.quantity not in _MOTIONS:
        return False  # a drive may log its own command as what it did
    if driven:
        return asked.role == "reference" and told.role != "reference"
    return told.role == "reference"


def _asked(spec: SignalSpec, names: Sequence[str]) -> _Meaning:
    told = [_told(name, "") for name in names]
    quantity = quantity_of_unit(spec.unit) or _first(one.quantity for one in told)
    role = _first(one.role for one in told)
    if quantity in _MOTIONS and not spec.driven:
        role = "measured"
    return _Meaning(quantity, role, frozenset().union(*(one.words for one in told)))


def _told(name: str, unit: str) -> _Meaning:
    words = _words(name)
    role = _first(role for role in _ROLES if any(_ROLE_OF.get(word) == role for word in words))
    quantity = quantity_of_unit(unit) or _first(_QUANTITY_OF.get(word, "") for word in words)
    return _Meaning(quantity, role, frozenset(words))


def _first(texts: Iterator[str]) -> str:
    return next(filter(None, texts), "")


def _words(name: str) -> list[str]:
    """Words of the last part of a name: act and pos of `MAIN.fbAxis.ActPos`."""
    found = [w.lower() for w in _WORD.findall(last_part(re.split(r"[:\\]", name)[-1]))]
    parts = [part for word in found for part in _parts(word)]
    pairs = [a + b for a, b in pairwise(found)]  # Set Point
    return [*found, *parts, *pairs]


def _parts(word: str) -> list[str]:
    """Parts of a compound with soll or ist: soll and winkel of `sollwinkel`."""
    split = _COMPOUND.fullmatch(word)
    rest = split and (split["first"] or split["last"])
    if not split or rest not in _QUANTITY_OF:
        return []  # such as list
    return [rest, *(part for part in (split[1], split[4]) if part)]


def _contradict(unit: str, wanted: str) -> bool:
    """Whether a column's unit is known, and is not of the quantity that is wanted."""
    known, other = parse_unit(unit) if unit else None, parse_unit(wanted) if wanted else None
    if known is None or other is None or known.needs_scale or known.si == "1":
        return False  # counts and shares of a rated value need a scale first
    return known.dimension != other.dimension


def _letters(name: str) -> str:
    return re.sub(r"[\W_]+", "", name).lower()


def _share_a_word(some: frozenset[str], others: frozenset[str]) -> bool:
    """Whether a word of three letters or more begins a word of the other name."""
    return any(
        one.startswith(other) or other.startswith(one)
        for one in some
        for other in others
        if min(len(one), len(other)) >= 3
    )


def _dimensions() -> dict[Dimension, str]:
    return {
        known.dimension: quantity
        for quantity, units in _UNITS.items()
        for unit in units
        if (known := parse_unit(unit)) is not None
    }


_QUANTITY_OF_DIMENSION = _dimensions()
