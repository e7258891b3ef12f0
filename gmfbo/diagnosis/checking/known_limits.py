"""Limits that a twin states for its signals: bounds of variables, parameters called limits."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gmfbo.sources.twin.twin import FmuTwin

_CALLED = re.compile(r"(limit|max|saturation)", re.IGNORECASE)


@dataclass(frozen=True)
class KnownLimit:
    """Limit of a signal's size, as the twin states it.

    Attributes
    ----------
    size : float
        [SI]
    source : str
        Variable or parameter that states it.
    """

    size: float
    source: str


def known_limit(twin: FmuTwin, signal: str, *, is_command: bool) -> KnownLimit | None:
    """Find the stated limit of a compared signal; None where the twin states none.

    Parameters
    ----------
    twin : FmuTwin
        The twin.
    signal : str
        In its [outputs].
    is_command : bool
        Whether the signal is the command: then a parameter named a limit, in its unit, counts.
    """
    binding = twin.binding
    name = twin.file.outputs[signal].variable
    variable = binding.variables[name].variable
    ends = [abs(end) for end in (variable.minimum, variable.maximum) if end is not None]
    if ends and max(ends) > 0.0:
        return KnownLimit(max(ends) * variable.to_si, name)
    if not is_command:
        return None
    found = []
    for other, bound in binding.variables.items():
        own = bound.variable
        if own.causality != "parameter" or own.value_type is None:
            continue
        last = other.rpartition(".")[2]
        if own.si_unit and own.si_unit == variable.si_unit and _CALLED.search(last):
            value = twin.nominal(other) * own.to_si
            if value > 0.0:
                found.append(KnownLimit(value, other))
    return min(found, key=lambda limit: limit.size, default=None)
