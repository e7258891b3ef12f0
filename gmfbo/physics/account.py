"""One effect in words: what it says, what it needs, what it is taken for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

from gmfbo.errors import InputError
from gmfbo.physics.effect import Effect, Units
from gmfbo.physics.example_axis import EXAMPLE_AXIS
from gmfbo.physics.needs import hidden_by, needed_states
from gmfbo.plain_words import listed, words
from gmfbo.units import unit_words

Answer = TypeVar("Answer")

_EITHER_IS_ENOUGH = ("position", "velocity")


def short_account(effect: Effect) -> list[tuple[str, str]]:
    """What is told of each effect in a list: heads, and their texts.

    Parameters
    ----------
    effect : Effect
        Of the catalogue, or added to it.

    Returns
    -------
    list of (str, str)
        Equation, sentence with the values of an example, and needs.

    Raises
    ------
    InputError
        A function of an added effect fails.
    """
    told = [("law", effect.equation), ("says", example_sentence(effect))]
    told.append(("needs", ", ".join(_needs(effect))))
    if hidden := _asked(effect, "not_excited", lambda: hidden_by(effect)):
        told.append(("hidden by", "; ".join(hidden)))
    return told


def full_account(effect: Effect) -> list[tuple[str, str]]:
    """All that is told of one effect: heads, and their texts.

    Parameters
    ----------
    effect : Effect
        Of the catalogue, or added to it.

    Returns
    -------
    list of (str, str)
        More than `short_account` has.

    Raises
    ------
    InputError
        A function of an added effect fails.
    """
    units = Units()
    told = short_account(effect)
    for parameter in effect.parameters:
        unit = unit_words(units.resolve(parameter.unit))
        name = f"{parameter.name} [{unit}]" if unit else parameter.name
        told.append(("parameter", f"{name}: {parameter.words}"))
    for other, motion in effect.confused_with.items():
        told.append(("looks like", f"{words(other)}; told apart by {motion}"))
    if effect.parameter_like:
        roles = listed(words(role) for role in effect.parameter_like)
        told.append(("looks like", f"the twin's own {roles}, where that is uncertain"))
    return [*told, ("source", effect.source)]


def example_sentence(effect: Effect) -> str:
    """Sentence of a diagnosis that names this effect on the example axis.

    Parameters
    ----------
    effect : Effect
        Of the catalogue, or added to it.

    Returns
    -------
    str
        With the values of its first start.

    Raises
    ------
    InputError
        A function of an added effect fails.
    """
    units = Units()

    def said() -> str:
        start = effect.starts(EXAMPLE_AXIS)[0]
        return effect.statement(start, units, units.place)

    return _asked(effect, "starts and statement", said)


def _asked(effect: Effect, what: str, ask: Callable[[], Answer]) -> Answer:
    """Answer of an effect's own functions; those of an added one are foreign code."""
    try:
        return ask()
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError(
            f"effect '{effect.name}': expected its {what} to answer for the example axis of "
            f"'gmfbo effects', got {reason}; correct the package that adds it"
        ) from error


def _needs(effect: Effect) -> Iterator[str]:
    yield f"a port '{effect.port}' under [ports]"
    states = [needed.any_of for needed in needed_states(effect)]
    if ("position",) in states:
        states.remove(_EITHER_IS_ENOUGH)
    yield f"[states] {listed(' or '.join(any_of) for any_of in states)}"
    if effect.inertia_share:
        yield "the shaft's inertia under [roles]"
