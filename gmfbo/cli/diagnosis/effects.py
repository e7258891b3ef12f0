"""`gmfbo effects`: the laws that a diagnosis can name, and what each needs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.completion import effects as effect_names
from gmfbo.cli.manual import Manual
from gmfbo.errors import InputError, did_you_mean
from gmfbo.plain_words import wrapped

if TYPE_CHECKING:
    from gmfbo.physics import Effect

INDENT = 12
"""[characters] Heads of an account."""

MANUAL = Manual(
    examples={
        "Which laws there are:": "gmfbo effects",
        "One of them, and what tells it from others:": "gmfbo effects coulomb_friction",
    },
    see_also=(
        "gmfbo check",
        "gmfbo diagnose",
        "notebooks/docs/effects.md",
        "notebooks/docs/own_effect.md",
    ),
)


def effects(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            help="Effect to tell in full; all of them in short without it.",
            autocompletion=effect_names,
        ),
    ] = None,
) -> None:
    """List the laws that a diagnosis can name.

    Each has its equation, the sentence of a diagnosis, what the twin file must hold, and which
    recordings hide it. Sentences have the values of an example: a motor shaft of 10 N m. Laws
    that installed packages add come last.
    """
    from gmfbo.physics import CATALOGUE
    from gmfbo.physics.account import full_account, short_account

    if name is not None:
        if name not in CATALOGUE:
            raise InputError(f"no effect '{name}'{did_you_mean(name, CATALOGUE)}")
        _print(CATALOGUE[name], full_account(CATALOGUE[name]))
        return
    for effect in CATALOGUE.values():
        _print(effect, short_account(effect))


def _print(effect: Effect, account: list[tuple[str, str]]) -> None:
    from gmfbo.physics import CATALOGUE

    typer.echo(effect.name)
    before = ""
    for head, text in account:
        shown = "" if head == before else head
        for line in wrapped(text, f"  {shown:<{INDENT}}"):
            typer.echo(line)
        before = head
    if effect in CATALOGUE.added:
        law = "added by a package; its law is in the FMU that GMFBO_PHYSICS names"
        for line in wrapped(law, f"  {'added':<{INDENT}}"):
            typer.echo(line)
