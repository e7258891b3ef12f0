"""Limits that a twin states for its signals: bounds of variables, parameters called limits."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gmfbo.sources.twin.twin import FmuTwin

_CALLED = re.compile(r"(limit|max|saturation)", re.IGNORECASE)


@dataclass(frozen=True)
class KnownLimit:
    """Size that a signal does not exceed in the twin.

    Attributes
    ----------
    size : float
        [SI]
    source : str
        Variable or parameter that says so.
    """

    size: float
    source: str


def known_limit(twin: FmuTwin, signal: str, *, is_command: bool) -> KnownLimit | None:
    """Find the limit of a signal that the twin is compared with; None where none is stated.

    Parameters
    ----------
    twin : FmuTwin
        The twin.
    signal : str
        In its [outputs].
    is_command : bool
        The controller's command: a parameter called a limit, in the same unit, is taken for its.
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
