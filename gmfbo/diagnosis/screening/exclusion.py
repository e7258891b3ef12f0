"""What the user rules out of a diagnosis: effects, and parameters of the twin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gmfbo.errors import InputError, did_you_mean
from gmfbo.physics import CATALOGUE
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.binding.name_patterns import matching
from gmfbo.sources.twin.twin import FmuTwin


@dataclass(frozen=True)
class Excluded:
    """Names that were ruled out.

    Attributes
    ----------
    effects : tuple of str
        Never named.
    parameters : tuple of str
        FMU parameters that keep the twin's value.
    """

    effects: tuple[str, ...]
    parameters: tuple[str, ...]

    def held_in(self, twin: FmuTwin) -> FmuTwin:
        """Return the twin with its excluded parameters certain; the same if there are none.

        Parameters
        ----------
        twin : FmuTwin
            The user's twin.
        """
        if not set(self.parameters) & set(twin.file.uncertain):
            return twin
        left = {n: r for n, r in twin.file.uncertain.items() if n not in self.parameters}
        return twin.with_uncertain(left)


def excluded(binding: Binding, names: Sequence[str]) -> Excluded:
    """Find the effects and parameters that names or shell patterns stand for.

    Parameters
    ----------
    binding : Binding
        The twin.
    names : sequence of str
        As the user gives them.

    Raises
    ------
    InputError
        One of them stands for nothing; the nearest name is told.
    """
    effects: dict[str, None] = {}
    parameters: dict[str, None] = {}
    for name in names:
        own = [name] if name in CATALOGUE else []
        of_twin = [] if own else matching(name, binding.parameters)
        if not own and not of_twin:
            raise InputError(
                f"no effect '{name}' to exclude, and no parameter of the twin matches it"
                + did_you_mean(name, [*CATALOGUE, *binding.parameters])
            )
        effects.update(dict.fromkeys(own))
        parameters.update(dict.fromkeys(of_twin))
    return Excluded(tuple(effects), tuple(parameters))


def check_assumed(binding: Binding, names: Sequence[str]) -> None:
    """Raise unless all names are those of effects.

    Parameters
    ----------
    binding : Binding
        The twin.
    names : sequence of str
        As the user gives them.

    Raises
    ------
    InputError
        A name is no effect, or is a parameter of the twin.
    """
    for name in names:
        if name in CATALOGUE:
            continue
        if name in binding.parameters:
            raise InputError(
                f"expected the name of an effect to assume, but '{name}' is a parameter of the "
                "twin; only effects are assumed, list a parameter under [uncertain]"
            )
        raise InputError(f"no effect '{name}' to assume" + did_you_mean(name, CATALOGUE))
