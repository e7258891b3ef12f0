"""What an effect needs from a twin file and from recordings before it can be named."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from gmfbo.physics.effect import Effect
from gmfbo.physics.example_axis import EXAMPLE_AXIS
from gmfbo.physics.excitation import Excitation

_FOR_FREE = ("velocity", "current")  # differentiated, or taken from the command


@dataclass(frozen=True)
class NeededState:
    """An entry of [states] that an effect needs.

    Attributes
    ----------
    any_of : tuple of str
        One of these is enough.
    lacking : str
        Words for a twin that names none of them.
    """

    any_of: tuple[str, ...]
    lacking: str


def needed_states(effect: Effect) -> tuple[NeededState, ...]:
    """Entries of [states] without which an effect cannot be tested.

    Parameters
    ----------
    effect : Effect
        Of the catalogue, or added to it.

    Returns
    -------
    tuple of NeededState
        In the order in which a twin is asked for them.
    """
    return tuple(_needed_states(effect))


def _needed_states(effect: Effect) -> Iterator[NeededState]:
    if effect.port == "command":
        yield NeededState(("command", "current"), "the twin names no state 'command'")
    place = "the twin names neither a position nor a velocity"
    yield NeededState(("position", "velocity"), place)
    further = [state for state in effect.requires if state not in _FOR_FREE]
    if effect.region_state == "position":
        further.insert(0, "position")
    for state in further:
        yield NeededState((state,), f"the twin names no state '{state}'")


def hidden_by(effect: Effect) -> tuple[str, ...]:
    """Motions and settings that keep recordings from showing an effect.

    Each is the effect's own reason on an axis that differs from the example in one thing.

    Parameters
    ----------
    effect : Effect
        Of the catalogue, or added to it.

    Returns
    -------
    tuple of str
        Reasons in words; none where any motion shows it.
    """
    reasons = (effect.not_excited(axis) for axis in _axes_that_show_little())
    return tuple(dict.fromkeys(reason for reason in reasons if reason is not None))


def _axes_that_show_little() -> Iterator[Excitation]:
    example = EXAMPLE_AXIS
    yield replace(example, reversals=0)
    yield replace(example, stroke=1e3 * example.resolution)
    yield replace(example, duration=example.loop_time)
    yield replace(example, angular=False)
    yield replace(example, sample=10.0 * example.loop_time)
