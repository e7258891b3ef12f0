"""How a case is played and logged: what new nulls do to recordings, and to nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from tests.blind.draw.mujoco_axis import simulate_in_mujoco
from tests.blind.hidden import Rng
from tests.blind.machines import Machine
from tests.blind.oracle import Experiment
from tests.blind.recording import Logger, csv_text
from tests.blind.truth import PREROLL, SAMPLE, TrueRun, Vector, simulate


@dataclass(frozen=True)
class Rig:
    """What stands between the plant and the file; all zero where nothing does.

    Attributes
    ----------
    loop_is_clean : bool
        The controller reads neither noise nor counts.
    position_noise : float
        [position] White noise of the logged position.
    position_count, command_count : float
        [position], [command] The logger rounds to these.
    jitter : float
        [s] Rows are read up to so much earlier or later than their time says.
    jitters_command : bool
        The command's column jitters with the position's.
    low_pass : float
        [s] Time constant of a first-order filter of one logged column.
    filtered : str
        That column: `position` or `command`.
    load : float
        [torque] Standard deviation of a torque at the shaft.
    load_corner : float
        [Hz] Where its spectrum begins to fall.
    rate : int
        Samples of the controller in a row of the logger.
    averages : bool
        A row is the mean over these samples; else the last one.
    mujoco_step : float
        [s] Step of the MuJoCo plant; 0: the plant is `truth.c`.
    mujoco_integrator : str
        As MuJoCo names it.
    """

    loop_is_clean: bool = False
    position_noise: float = 0.0
    position_count: float = 0.0
    command_count: float = 0.0
    jitter: float = 0.0
    jitters_command: bool = False
    low_pass: float = 0.0
    filtered: str = ""
    load: float = 0.0
    load_corner: float = 0.0
    rate: int = 1
    averages: bool = False
    mujoco_step: float = 0.0
    mujoco_integrator: str = ""

    def changed(self, **changes: Any) -> Rig:
        """Return the same rig with other faults."""
        return replace(self, **changes)

    def told(self) -> dict[str, Any]:
        """What is not as usual, for the answer."""
        usual = asdict(Rig())
        return {key: value for key, value in asdict(self).items() if value != usual[key]}


def record_with(
    rig: Rig,
    machine: Machine,
    values: Mapping[str, float],
    experiment: Experiment,
    logger: Logger,
    rng: Rng,
) -> str:
    """Text of a CSV file of one noisy run.

    Parameters
    ----------
    rig : Rig
        How it is played and logged.
    machine : Machine
        For noise, names and units.
    values : mapping of str to float
        Of the true plant, gains included.
    experiment : Experiment
        Reference and gains.
    logger : Logger
        Its own faults beside those of the rig.
    rng : Generator
        Noise.
    """
    position, command = logged_with(rig, machine, values, experiment, logger, rng)
    time = np.asarray(np.arange(len(position)) * SAMPLE * (1.0 + logger.skew), dtype=float)
    return csv_text(machine, experiment, time, position, command)


def logged_with(
    rig: Rig,
    machine: Machine,
    values: Mapping[str, float],
    experiment: Experiment,
    logger: Logger,
    rng: Rng,
) -> tuple[Vector, Vector]:
    """Columns of position [position] and command [command] of the same, shape (rows,) each."""
    rows = len(experiment.reference)
    run = _play(rig, machine, values, experiment.reference, rng)
    position, command = _columns(rig, run, logger, rng)
    if rig.low_pass:
        share = -np.expm1(-SAMPLE / rig.low_pass)
        if rig.filtered == "position":
            position = _filtered(position, share)
        else:
            command = _filtered(command, share)
    position = position + rig.position_noise * rng.standard_normal(rows)
    command = logger.scale * (command + logger.noise(machine.command_noise, rows, rng))
    return _counted(position, rig.position_count), _counted(command, rig.command_count)


def _play(
    rig: Rig, machine: Machine, values: Mapping[str, float], reference: Vector, rng: Rng
) -> TrueRun:
    """One run with noise in the loop and at the shaft, a row for each sample of the controller."""
    sample = SAMPLE / rig.rate
    samples = PREROLL + len(reference) * rig.rate
    jitter = 0.0 if rig.loop_is_clean else machine.jitter
    noise = jitter * rng.standard_normal(samples)
    load = rig.load * coloured(samples, sample, rig.load_corner, rng) if rig.load else None
    values = {**values, "quantum": 0.0 if rig.loop_is_clean else machine.quantum}
    if rig.mujoco_step:
        return simulate_in_mujoco(
            values, reference, noise, step=rig.mujoco_step, integrator=rig.mujoco_integrator
        )
    if rig.rate > 1:
        values["sample"] = sample
    return simulate(values, np.repeat(reference, rig.rate), noise, load=load)


def coloured(samples: int, sample: float, corner: float, rng: Rng) -> Vector:
    """Noise of unit variance with the spectrum of a first-order low pass.

    Parameters
    ----------
    samples : int
        How many.
    sample : float
        [s] Between two of them.
    corner : float
        [Hz] Where the spectrum has fallen to half.
    rng : Generator
        Draws it.
    """
    memory = np.exp(-2.0 * np.pi * corner * sample)
    white = rng.standard_normal(samples)
    white[0] /= np.sqrt(1.0 - memory**2)  # the first one is as large as all others
    return np.asarray(lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], white))


def _columns(rig: Rig, run: TrueRun, logger: Logger, rng: Rng) -> tuple[Vector, Vector]:
    """Position and command of each row of the logger."""
    command = run.new if logger.convention == "new" else run.held
    if rig.rate > 1:
        return _slower(run.reading, rig), _slower(command, rig)
    if not rig.jitter:
        return run.reading, command
    late = rng.uniform(-rig.jitter, rig.jitter, len(command))
    at = np.arange(len(command)) * SAMPLE
    moved = CubicSpline(at, run.position)(np.clip(at + late, at[0], at[-1]))
    if rig.jitters_command:
        command = np.where(late > 0.0, run.new, run.held)
    return moved + run.reading - run.position, command


def _slower(column: Vector, rig: Rig) -> Vector:
    """Rows of a logger that keeps one of `rate` samples, or the mean of the last ones."""
    if not rig.averages:
        return column[:: rig.rate]
    padded = np.concatenate([np.full(rig.rate - 1, column[0]), column])
    return np.asarray(padded[: len(column)].reshape(-1, rig.rate).mean(axis=1))


def _filtered(column: Vector, share: float) -> Vector:
    """First-order low pass from rest at the first row."""
    first = column[0]
    return np.asarray(first + lfilter([share], [1.0, share - 1.0], column - first))


def _counted(column: Vector, count: float) -> Vector:
    return count * np.floor(column / count + 0.5) if count else column
