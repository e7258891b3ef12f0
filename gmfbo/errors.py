"""One error tree; every message says what was expected, what came and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

_LONGEST_NAME = 300
_LONGEST_MESSAGE = 2500


class GmfboError(Exception):
    """Root of all errors of gmfbo; `exit_status` is what the command line returns."""

    exit_status = 1

    def __str__(self) -> str:
        """The message, cut and without control characters that a hostile file put into it."""
        text = super().__str__()
        if len(text) > _LONGEST_MESSAGE:  # keep the end, which holds the cure
            text = f"{text[: _LONGEST_MESSAGE - 400]} ... {text[-400:]}"
        if text.isprintable():
            return text
        return "".join(c if c.isprintable() or c in "\n\t" else "?" for c in text)


class InputError(GmfboError):
    """An input of the user cannot be used; nothing already recorded is lost."""

    exit_status = 2


class FmuFileError(InputError):
    """An FMU file cannot be opened, or cannot run on this machine."""


class TwinFileError(InputError):
    """A twin file contradicts itself or its FMU."""


class RecordingError(InputError):
    """A recording cannot be read or does not fit its twin."""


class OwnMetricsError(RecordingError):
    """A user's own metrics cannot be computed of a run."""


class StudyFileError(InputError):
    """A study file cannot be used."""


class ExhaustedError(InputError):
    """All gains that could be asked for were run already."""


class StoreError(InputError):
    """A study folder cannot be written or read."""


class ExportError(InputError):
    """An augmented twin cannot be written as one FMU; its diagnosis stays valid."""


class SimulationError(GmfboError):
    """An FMU or a plant failed: it crashed, hung or refused."""

    exit_status = 3


class NotTheGainsError(SimulationError):
    """A real run failed for a reason that is not its gains; the same trial is asked again."""


def in_short(reason: object, most: int = 300) -> str:
    """Text of a library or file as one line of limited length, without control characters.

    Parameters
    ----------
    reason : object
        An exception or a text.
    most : int
        Largest number of characters.
    """
    text = " ".join(str(reason).split()) or type(reason).__name__
    text = "".join(letter if letter.isprintable() else "?" for letter in text[: most + 1])
    return text if len(text) <= most else text[: most - 3] + "..."


def did_you_mean(name: str, choices: Iterable[str]) -> str:
    """End of a message that names the nearest valid choice, or lists a few.

    Returns
    -------
    str
        Begins with a blank or a semicolon, so that it can be appended; empty without choices.
    """
    known = sorted(set(choices))
    name = name[:_LONGEST_NAME]  # comparing takes time by the square of the length
    # Case is the commonest slip in FMU variable names, so it does not count.
    folded = {choice.lower(): choice for choice in reversed(known) if len(choice) < _LONGEST_NAME}
    nearest = get_close_matches(name.lower(), folded, n=1, cutoff=0.5)
    if nearest:
        return f"; did you mean '{folded[nearest[0]]}'?"
    if not known:
        return ""
    shown = ", ".join(in_short(choice, 60) for choice in known[:8])
    more = f" and {len(known) - 8} more" if len(known) > 8 else ""
    return f"; known are {shown}{more}"
