"""Console and small text formats that commands share."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rich.console import Console

from gmfbo.errors import InputError
from gmfbo.plain_words import wrapped

# Soft wrap, so that no table or path is cut where output goes to a file.
console = Console(soft_wrap=True, highlight=False)


def parse_settings(settings: list[str], *, option: str = "--set") -> dict[str, float]:
    """Values by name from `NAME=VALUE` arguments.

    Parameters
    ----------
    settings : list of str
        The arguments.
    option : str
        Option that they were given to, for messages.

    Raises
    ------
    InputError
        An argument has no `=`, or its value is not a number.
    """
    values: dict[str, float] = {}
    for setting in settings:
        # A quoted FMI name may itself hold an equals sign; a number cannot.
        name, equals, text = setting.rpartition("=")
        if not equals or not name:
            raise InputError(f"{option}: expected NAME=VALUE, got '{setting}'")
        try:
            values[name.strip()] = float(text)
        except ValueError:
            raise InputError(f"{option} {name}: expected a number, got '{text}'") from None
    return values


def parse_words(settings: list[str], known: Collection[str]) -> dict[str, float | str]:
    """Values by name from `NAME=VALUE` arguments, as they were typed.

    Parameters
    ----------
    settings : list of str
        The arguments.
    known : collection of str
        Names that there are. Both a quoted FMI name and a text may hold an equals sign.

    Raises
    ------
    InputError
        An argument has no `=`.
    """
    values: dict[str, float | str] = {}
    for setting in settings:
        name, equals, text = setting.rpartition("=")
        if not equals or not name:
            raise InputError(f"--set: expected NAME=VALUE, got '{setting}'")
        parts = setting.split("=")
        for k in range(1, len(parts)):
            if "=".join(parts[:k]).strip() in known:
                name, text = "=".join(parts[:k]), "=".join(parts[k:])
                break
        values[name.strip()] = text
    return values


def whole_words(text: str, head: str) -> list[str]:
    """Lines of a text behind a head, 79 columns at most; the text's own lines stay lines.

    Parameters
    ----------
    text : str
        May have lines that are indented.
    head : str
        Begins the first line; the others are indented by as much.
    """
    lines = []
    for line in text.splitlines():
        indented = line[: len(line) - len(line.lstrip())]
        lines += wrapped(line.strip(), head + indented)
        head = " " * len(head)
    return lines


def gains_text(gains: Mapping[str, float]) -> str:
    """Gains on one line, four significant digits."""
    return ", ".join(f"{name} = {value:.4g}" for name, value in gains.items())
