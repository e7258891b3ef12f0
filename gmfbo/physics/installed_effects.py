"""Find effects of installed packages by their entry points."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import entry_points

from gmfbo.errors import InputError
from gmfbo.physics.effect import Effect

GROUP = "gmfbo.effects"


def installed_effects() -> Iterator[Effect]:
    """All effects that packages add.

    Raises
    ------
    InputError
        One of them cannot be loaded, or is no effect.
    """
    for entry in entry_points(group=GROUP):
        try:
            effect = entry.load()
        except Exception as error:
            reason = f"{type(error).__name__}: {error}".splitlines()[0]
            raise InputError(
                f"effect '{entry.name}': cannot load {entry.value} ({reason}); "
                "repair or uninstall the package that adds it"
            ) from error
        if not isinstance(effect, Effect):
            raise InputError(
                f"effect '{entry.name}': expected {entry.value} to be a gmfbo.physics.Effect, got "
                f"{type(effect).__name__}"
            )
        yield effect
