"""How much finer the counts of an encoder are made, that a simulation has none to speak of."""

from __future__ import annotations

from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.uncertain import Uncertain

FINER = 1000.0
"""Counts in the place of one."""

ENOUGH = 10.0
"""Counts in the place of one that would do."""


def times(twin: FmuTwin, parameter: Uncertain, factor: float) -> float:
    """[FMU's unit] So many times the value of a parameter, or as much as the FMU allows.

    Parameters
    ----------
    twin : FmuTwin
        Whose FMU bounds it.
    parameter : Uncertain
        About its nominal value.
    factor : float
        Times that value.
    """
    value = parameter.nominal * factor
    variable = twin.binding.parameters[parameter.name].variable
    if variable.minimum is not None:
        value = max(value, variable.minimum)
    return value if variable.maximum is None else min(value, variable.maximum)
