"""What a logger writes of a true run: noise, its own convention, scale and clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.signal import lfilter

from tests.blind.machines import Machine
from tests.blind.oracle import Experiment
from tests.blind.truth import PREROLL, SAMPLE, Vector, simulate


@dataclass(frozen=True)
class Logger:
    """How the command's column and the clock are off.

    Attributes
    ----------
    convention : str
        `held`: row k holds the command in force just before t_k; `new`: the one computed there.
    scale : float
        Of the command's column.
    skew : float
        Its clock runs faster by this share.
    colour : float
        Correlation of the command's noise from row to row; with any, it is three times as large.
    """

    convention: str
    scale: float = 1.0
    skew: float = 0.0
    colour: float = 0.0

    def changed(self, **changes: Any) -> Logger:
        """Return the same logger with other faults."""
        return replace(self, **changes)

    def told(self) -> dict[str, Any]:
        """Its faults, for the answer."""
        return {
            "convention": self.convention,
            "column_scale": self.scale,
            "clock_skew": self.skew,
            "noise_colour": self.colour,
        }

    def noise(self, size: float, rows: int, rng: np.random.Generator) -> Vector:
        """Noise of the command's column, of standard deviation `size` where it is white."""
        white = rng.standard_normal(rows)
        if not self.colour:
            return size * white
        coloured = lfilter([np.sqrt(1.0 - self.colour**2)], [1.0, -self.colour], white)
        return np.asarray(3.0 * size * coloured)


def record(
    machine: Machine,
    values: Mapping[str, float],
    experiment: Experiment,
    logger: Logger,
    rng: np.random.Generator,
) -> str:
    """Text of a CSV file of one noisy run.

    Parameters
    ----------
    machine : Machine
        For its noise, names and units.
    values : mapping of str to float
        Of the true plant, gains and hidden effects included.
    experiment : Experiment
        Reference and gains.
    logger : Logger
        What writes it.
    rng : Generator
        Noise.
    """
    rows = len(experiment.reference)
    jitter = machine.jitter * rng.standard_normal(PREROLL + rows)
    run = simulate({**values, "quantum": machine.quantum}, experiment.reference, jitter)
    command = run.new if logger.convention == "new" else run.held
    command = logger.scale * (command + logger.noise(machine.command_noise, rows, rng))
    time = np.asarray(np.arange(rows) * SAMPLE * (1.0 + logger.skew), dtype=float)
    return csv_text(machine, experiment, time, run.reading, command)


def csv_text(
    machine: Machine, experiment: Experiment, time: Vector, position: Vector, command: Vector
) -> str:
    """Text of the CSV file that holds what was logged.

    Parameters
    ----------
    machine : Machine
        For names and units.
    experiment : Experiment
        Reference and gains.
    time, position, command : ndarray, shape (rows,)
        The logged columns [s], [position], [command].
    """
    position_unit, command_unit, _ = machine.units
    columns = {"time [s]": time}
    if not machine.is_open_loop:
        columns[f"reference [{position_unit}]"] = experiment.reference
    columns[f"position [{position_unit}]"] = position
    columns[f"{machine.command_name} [{command_unit}]"] = command
    head = [f"# {machine.gains[own]} = {value!r}" for own, value in experiment.gains.items()]
    table = np.column_stack(list(columns.values()))
    lines = [",".join(f"{cell:.9g}" for cell in row) for row in table.tolist()]
    return "\n".join([*head, ",".join(columns), *lines, ""])
