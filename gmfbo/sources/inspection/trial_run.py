"""Trial run: the first steps of an FMU, before it is used."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gmfbo.errors import ExportError, FmuFileError, SimulationError
from gmfbo.sources.binding.bind import bind
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.fmu_file.job import Job
from gmfbo.sources.twin_file.twin_file import TwinFile
from gmfbo.sources.worker.isolation import Isolated
from gmfbo.sources.worker.runner import Order

_TIME_LIMIT_S = 60.0
_STEPS = 2


def try_out(twin_file: Path) -> None:
    """Instantiate an exported FMU in a process of its own and step it.

    Raises
    ------
    ExportError
        The FMU does not run, though its parts do.
    """
    file = TwinFile.read(twin_file)
    try:
        take_first_steps(bind(file, twin_file.parent, twin_file.name), file.step)
    except (FmuFileError, SimulationError) as error:
        raise _refusal(str(error)) from None


def take_first_steps(binding: Binding, step: float) -> int:
    """Step FMUs in a process of their own; returns the number of steps.

    Parameters
    ----------
    binding : Binding
        The twin.
    step : float
        [s] Communication step.

    Raises
    ------
    FmuFileError
        A library cannot be loaded.
    SimulationError
        They do not run.
    """
    runner = Isolated(binding, time_limit_s=_TIME_LIMIT_S)
    try:
        order = Order(Job(_STEPS, 0.0, step), np.empty((_STEPS, 0)), np.empty((_STEPS, 0)))
        outcome = runner.run(order)[0].outcome
    finally:
        runner.close()
    if outcome.status != "ok":
        raise SimulationError(outcome.message)
    return _STEPS


def _refusal(reason: str) -> ExportError:
    return ExportError(
        f"the augmented FMU does not run, though its parts do: {reason}; the diagnosis holds "
        "without it"
    )
