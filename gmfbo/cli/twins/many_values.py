"""Options that take several values after one flag: `--validate a.csv b.csv`."""

from __future__ import annotations

from typing import Any

from gmfbo.cli.manual import ManualCommand


class ManyValuesCommand(ManualCommand):
    """A command whose list options take all values up to the next flag.

    Only options named in `many` do so; a bare `--` ends their values, as it ends options.
    """

    many: tuple[str, ...] = ("--validate",)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Repeat the flag before each of its values, as the parser expects."""
        return super().parse_args(ctx, repeat_flags(args, self.many))


def repeat_flags(arguments: list[str], many: tuple[str, ...]) -> list[str]:
    """Write `--flag a b` as `--flag a --flag b`.

    Parameters
    ----------
    arguments : list of str
        As typed.
    many : tuple of str
        Flags whose values go on up to the next flag.

    Returns
    -------
    list of str
        The same, with each of those flags before each of its values.
    """
    spread: list[str] = []
    flag, waiting = "", False  # `spread` already holds a flag before its first value
    for position, argument in enumerate(arguments):
        if argument == "--":
            return [*spread, *arguments[position:]]
        if argument.startswith("-") and argument != "-":
            flag, waiting = (argument, True) if argument in many else ("", False)
            spread.append(argument)
        elif flag and not waiting:
            spread += [flag, argument]
        else:
            waiting = False
            spread.append(argument)
    return spread
