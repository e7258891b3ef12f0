"""Sections of `--help` beside arguments and options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from typer.core import TyperCommand, TyperGroup

from gmfbo.plain_words import wrapped

EXITS = {
    0: "done",
    1: "a fault of gmfbo's own; it names a file to report",
    2: "bad input: one line says what was expected, what came, what to do",
    3: "a simulation or a plant failed: it crashed, hung or refused",
    130: "interrupted; all finished work is kept",
}
"""Meanings of the exit statuses of all commands."""


@dataclass(frozen=True)
class Manual:
    """Sections of a manual page that belong to no option.

    Attributes
    ----------
    examples : mapping of str to str
        What one wants, and the command line for it.
    files : mapping of str to str
        What is written, and what it is.
    exits : mapping of int to str
        What an exit status means here, where that is more than `EXITS` says.
    see_also : tuple of str
        Other commands and pages of the documentation.
    """

    examples: Mapping[str, str]
    files: Mapping[str, str] = field(default_factory=dict)
    exits: Mapping[int, str] = field(default_factory=dict)
    see_also: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """Text of the sections below the options."""
        exits = {str(status): meaning for status, meaning in {**EXITS, **self.exits}.items()}
        sections = [
            definitions("Files written", self.files),
            _section("Examples", _examples(self.examples)),
            definitions("Exit status", exits),
            _section("See also", wrapped(", ".join(self.see_also), "  ")),
        ]
        return "\n".join(section for section in sections if section)


def definitions(title: str, entries: Mapping[str, str]) -> str:
    """A section of terms with their meanings; empty without entries."""
    width = max((len(term) for term in entries), default=0)
    lines = []
    for term, meaning in entries.items():
        head = f"  {term:<{width}}  " if width else "  "
        lines += wrapped(meaning, head if term else "  ")
    return _section(title, lines)


def _examples(examples: Mapping[str, str]) -> list[str]:
    lines = []
    for purpose, command in examples.items():
        lines += [*wrapped(purpose, "  "), f"    {command}"]
    return lines


def _section(title: str, lines: list[str]) -> str:
    return "\n".join([f"{title}:", *lines, ""]) if lines else ""


class ManualCommand(TyperCommand):
    """A command whose help reads like a manual page; its epilog is already formatted."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Usage line: required arguments first."""
        pieces = []
        for parameter in self.get_params(ctx):
            if parameter.param_type_name == "argument":
                pieces.append(parameter.metavar or parameter.name)
            elif parameter.required:
                pieces.append(f"{parameter.opts[0]} {parameter.metavar}")
        return [*pieces, "[OPTIONS]"]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Arguments and options; arguments are named as in the usage line."""
        rows: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None and parameter.param_type_name == "argument":
                rows["Arguments"].append((parameter.metavar or parameter.name, record[1]))
            elif record is not None:
                rows["Options"].append(record)
        for title, entries in rows.items():
            if entries:
                with formatter.section(title):
                    formatter.write_dl(entries)

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """The epilog as it is."""
        _write_epilog(self.epilog, formatter)


class ManualGroup(TyperGroup):
    """The program, whose epilog is already formatted too."""

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """The epilog as it is."""
        _write_epilog(self.epilog, formatter)


def _write_epilog(epilog: str | None, formatter: Any) -> None:
    if epilog:
        formatter.write(f"\n{epilog.rstrip()}\n")
