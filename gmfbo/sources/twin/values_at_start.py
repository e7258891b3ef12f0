"""Order of the shortest run, made to read variables after initialisation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gmfbo.errors import InputError, did_you_mean
from gmfbo.recordings.recording import Recording
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.fmu_file.job import Job
from gmfbo.sources.twin.parameter_values import run_parameters
from gmfbo.sources.twin.run_plan import announced_stop
from gmfbo.sources.worker.runner import Order


def initial_order(
    binding: Binding,
    names: Sequence[str],
    parameters: Mapping[str, float],
    texts: Mapping[str, str] | None = None,
) -> Order:
    """Order of one communication step that reads some variables.

    Parameters
    ----------
    binding : Binding
        The twin.
    names : sequence of str
        Variables to read.
    parameters : mapping of str to float
        [FMU's unit] Over the twin file's.
    texts : mapping of str to str, optional
        Parameters of type String, over the twin file's.

    Raises
    ------
    InputError
        A name is unknown, or a value outside the FMU's bounds.
    """
    for name in names:
        if name not in binding.variables:
            raise InputError(f"no FMU variable '{name}'" + did_you_mean(name, binding.variables))
    still = Recording(time=np.array([0.0, binding.file.step]), signals={})
    chosen = run_parameters(binding, still, parameters, {}, texts)
    job = Job(
        steps=1,
        start=0.0,
        step=binding.file.step,
        settings=chosen.settings,
        texts=chosen.texts,
        stop=announced_stop(binding.file, 0.0, 1, binding.file.step),
        wires=binding.wires,
        outputs=tuple(binding.variables[name].port(k) for k, name in enumerate(names)),
    )
    return Order(job, np.empty((1, 0)), np.empty((1, 0)))
