"""FMUs that take one communication step only."""

from __future__ import annotations

import math

from gmfbo.sources.binding.binding import Binding


def fixed_step_advice(binding: Binding, step: float) -> str:
    """Advice for a failed run: the only step that an FMU takes; empty where the step fits.

    Parameters
    ----------
    binding : Binding
        The twin.
    step : float
        [s] Communication step of the run.
    """
    for fmu in binding.fmus:
        varies = fmu.capabilities.get("canHandleVariableCommunicationStepSize", True)
        own = fmu.default_step
        if not varies and own is not None and not math.isclose(own, step, rel_tol=1e-9):
            return f"; '{fmu.path.name}' takes one step only: set step = {own:g} in the twin file"
    return ""
