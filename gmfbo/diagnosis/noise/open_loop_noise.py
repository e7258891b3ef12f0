"""Remove measurement noise from the command and tracking loop of an open-loop plant.

A recorded closed-loop command holds the controller's answer to the noise of the recorded position.
So an open-loop plant that runs on this command is driven by the same noise that its residual holds.
A residual scored below 200 Hz is not white in time, and a model gains by explaining this noise from
the command: half of a delay of 1.4 ms is then fitted, and the rest as a soft shaft (Ljung 1999,
sec. 13.4: closed-loop data with a wrong noise model). The tracking loop passes the noise on too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.noise.noise_corner import above, corner_of_noise, fast_bins
from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.noise_levels import noise_level, rounding_of
from gmfbo.diagnosis.scoring.signal_parts import Rig
from gmfbo.sources.twin.augmented_twin import RunPlan

Array = NDArray[np.float64]

_ANSWERS_WITHIN_S = 5e-3
_LEAST_SHARE = 0.1  # of a command's fast power: by chance, 5 regressors explain 1 % of 500 rows


@dataclass(frozen=True, eq=False)
class ReadNoise:
    """Fast noise of one recording's position.

    Attributes
    ----------
    difference : ndarray, shape (rows,)
        [SI] Recorded less simulated position on the communication grid.
    step : float
        [s] Of the grid.
    corner : float
        [Hz] Frequency above which the difference is noise.
    """

    difference: Array
    step: float
    corner: float

    @property
    def column(self) -> Array:
        """[SI] The noise on the communication grid, shape (rows,)."""
        return above(self.difference, self.step, self.corner)

    def answer_in(self, command: Array) -> tuple[Array, float]:
        """Part of a command that responds to the noise, and its share of the fast power.

        A controller answers noise in the same way all the time. So the share is what the response
        that was found in one half of the recording explains in the other: few lines of a clean
        command are matched by chance in each half, but by another response.

        Parameters
        ----------
        command : ndarray, shape (rows,)
            On the communication grid.
        """
        delays = np.arange(int(np.ceil(_ANSWERS_WITHIN_S / self.step)) + 1)
        halves = [self._fast_half(command, delays, k) for k in range(2)]
        found = [np.linalg.lstsq(late, fast, rcond=None)[0] for late, fast in halves]
        left = sum(
            float(np.sum((fast - late @ other) ** 2))
            for (late, fast), other in zip(halves, reversed(found), strict=True)
        )
        power = sum(float(np.sum(fast**2)) for _, fast in halves)
        late, fast = (np.concatenate(part) for part in zip(*halves, strict=True))
        response = np.linalg.lstsq(late, fast, rcond=None)[0]
        noise = self.column
        answer: Array = sum(
            share * np.roll(noise, n) * (np.arange(noise.size) >= n)
            for n, share in zip(delays, response, strict=True)
        )
        return answer, 1.0 - left / power if power > 0.0 else 0.0  # a coast-down has no command

    def _fast_half(
        self, command: Array, delays: NDArray[np.int64], half: int
    ) -> tuple[Array, Array]:
        """Fast bins of the noise at each delay and of the command, in a half of the recording."""
        first, middle, last = int(delays[-1]), command.size // 2, command.size
        start, end = ((first, middle), (middle, last))[half]
        late = [self.difference[start - n : end - n] for n in delays]
        bins = fast_bins(np.array([*late, command[start:end]]), self.step, self.corner)
        parts = np.concatenate([bins.real, bins.imag], axis=1)
        return parts[:-1].T, parts[-1]


def leave_out_noise(simulations: Simulations, rig: Rig, model: Fitted) -> float | None:
    """Drive a plant in open loop without the noise of its recorded positions.

    The model's response to this noise is also subtracted from the recorded signals, since the
    error budget does not contain it.

    Parameters
    ----------
    simulations : Simulations
        With a tracking loop; loop and records are replaced.
    rig : Rig
        Roles of the signals.
    model : Fitted
        The noise is this model's position residual, where that is white.

    Returns
    -------
    float or None
        Median share of the commands' fast power that responds to the noise; None where no noise
        could be read, and nothing is changed.
    """
    tracking, records = simulations.tracking, simulations.records
    if tracking is None or rig.position is None:
        return None
    noise = [
        _read(record, run, rig.position)
        for record, run in zip(records, model.simulated, strict=True)
    ]
    if not any(noise):
        return None
    measured = tuple(
        column if own is None else column - own.column / rig.position_to_si
        for column, own in zip(tracking.measured, noise, strict=True)
    )
    quieted = [
        (record, 0.0) if own is None else _without_answers(record, own)
        for record, own in zip(records, noise, strict=True)
    ]
    simulations.tracking = replace(tracking, measured=measured)
    simulations.replace_records([record for record, _ in quieted])
    after = simulations.run([model.hypothesis.point(model.x)])[0]
    if not all(run.finite for run in after):
        simulations.tracking = tracking
        simulations.replace_records(records)
        return None
    simulations.replace_records(
        [
            _without_motion(record, before, quiet)
            for (record, _), before, quiet in zip(quieted, model.simulated, after, strict=True)
        ]
    )
    return float(np.median([share for _, share in quieted]))


def _read(record: Record, run: Simulated, position: str) -> ReadNoise | None:
    recording, grid = record.plan.recording, record.plan.grid
    signal = next((s for s in record.signals if s.name == position), None)
    if signal is None or recording.time.size != grid.size:
        return None
    if not np.allclose(recording.time, grid, atol=1e-7):
        return None
    difference = recording.signal(position) - run.response.held[position]
    if not np.all(np.isfinite(difference)):
        return None
    step = float(grid[1] - grid[0])
    level = noise_level(signal, difference)
    if level.total <= level.least and rounding_of(signal) < level.least:
        return None  # of so little, the simulation's own errors and leakage are the most
    corner = corner_of_noise(difference, step, level.total)
    if corner is None:
        return None
    return ReadNoise(difference, step, corner)


def _without_answers(record: Record, noise: ReadNoise) -> tuple[Record, float]:
    plan = record.plan
    inputs, shares = dict(plan.experiment.inputs), [0.0]
    for name, column in inputs.items():
        answer, share = noise.answer_in(column)
        if share > _LEAST_SHARE:
            inputs[name] = column - answer
            shares.append(share)
    experiment = replace(plan.experiment, inputs=inputs)
    quiet = RunPlan.after(plan.recording, experiment, plan.lead, plan.substeps)
    return replace(record, plan=quiet), max(shares)


def _without_motion(record: Record, before: Simulated, after: Simulated) -> Record:
    moved = zip(record.signals, before.signals, after.signals, strict=True)
    signals = tuple(replace(s, values=s.values - (own - quiet)) for s, own, quiet in moved)
    return replace(record, signals=signals)
