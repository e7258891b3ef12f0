"""Values of parameters in the words of their type: texts, truth values, enumeration items."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from gmfbo.errors import InputError, did_you_mean
from gmfbo.sources.binding.bound_variable import BoundVariable
from gmfbo.sources.fmu_file.fmu_variable import is_text_parameter

_TRUTHS = {"true": 1.0, "1": 1.0, "false": 0.0, "0": 0.0}


@dataclass(frozen=True)
class GivenValues:
    """Values of parameters by name.

    Attributes
    ----------
    numbers : dict of str to float
        [FMU's unit]
    texts : dict of str to str
        Of parameters of type String.
    """

    numbers: dict[str, float] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)


def given_values(
    label: str,
    variables: Mapping[str, BoundVariable],
    parameters: Mapping[str, BoundVariable],
    given: Mapping[str, float | str],
) -> GivenValues:
    """Sort values, as numbers or as words, by the type of their parameter.

    Parameters
    ----------
    label : str
        Name of the twin, for messages.
    variables, parameters : mapping of str to BoundVariable
        All variables of the twin, and those that may be set to numbers.
    given : mapping of str to float or str
        By name. A number may also be written as a word.

    Raises
    ------
    InputError
        A name is unknown, or a word is no value of its parameter's type.
    """
    values = GivenValues()
    for name, value in given.items():
        bound = variables.get(name)
        known = bound is not None and (name in parameters or _is_text(bound))
        if bound is None or not known:
            choices = [n for n, v in variables.items() if _is_text(v)]
            raise InputError(
                f"{label}: no FMU parameter '{name}'" + did_you_mean(name, [*parameters, *choices])
            )
        if _is_text(bound):
            values.texts[name] = as_text(bound, value)
        else:
            values.numbers[name] = as_number(bound, value)
    return values


def as_text(bound: BoundVariable, value: float | str) -> str:
    """Value of a parameter of type String.

    Raises
    ------
    InputError
        It is a number, or holds a NUL.
    """
    if not isinstance(value, str):
        raise InputError(f"parameter '{bound.name}': expected a text in quotes, got {value:g}")
    if "\0" in value:
        raise InputError(f"parameter '{bound.name}': expected a text without NUL")
    return value


def as_number(bound: BoundVariable, value: float | str) -> float:
    """Number of a value in the words of its variable's type.

    Raises
    ------
    InputError
        The word is none of the type's; the message lists those that are.
    """
    if not isinstance(value, str):
        return float(value)
    word = value.strip()
    if bound.variable.type == "Boolean":
        if word.lower() in _TRUTHS:
            return _TRUTHS[word.lower()]
        raise InputError(
            f"parameter '{bound.name}': expected a Boolean: true or false (1 or 0), got '{word}'"
        )
    items = dict(bound.variable.items)
    if word in items:
        return float(items[word])
    try:
        return float(word)
    except ValueError:
        expected = f"one of {bound.items_told}" if items else "a number"
        raise InputError(f"parameter '{bound.name}': expected {expected}, got '{word}'") from None


def _is_text(bound: BoundVariable) -> bool:
    return is_text_parameter(bound.variable)
