"""Replayed noise: the fast sensor noise of a recording, played into the twin.

Encoder noise reaches the motor through the controller. It overcomes small friction and bridges
small dead zones, so that a twin without it behaves otherwise. A model is scored with the slow
changes that this noise causes. The fast part is left to the error budget, since there a model's own
error would be read as noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.fitting.linear_left_out import square_after_refit
from gmfbo.diagnosis.fitting.misfit import Misfit, chi2
from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.noise_levels import noise_level
from gmfbo.sources.twin.augmented_twin import Response

Array = NDArray[np.float64]

_CORNERS = (30.0, 45.0, 65.0, 95.0, 140.0, 200.0)  # [Hz] above which noise is played
_WHITE = 1.6  # times the level near the Nyquist frequency: above it, the signal is motion
_SLOWER = 0.3  # of the sampling frequency: above this corner a signal has no fast part
_ROUNDS = 7  # most readings of the noise, each beside the axis' response to the last
_SETTLED = 0.01  # of the noise: a smaller change ends the rounds
_CONTAINED = 0.5  # of the sensor port's noise: a reading that shows more contains the port
_END = 0.02  # of a recording, at each end
_TRANSIENT = 4.0  # times the level: more at an end of the recording is a transient, not noise
_FELT = 30.0  # least chi2 of the slow change by relevant noise; its onset alone causes up to 15
_WORSE = 1.1  # times a signal's fast residual: noise that raises it more never reached the motor


class Showing(Enum):
    """When a simulated reading contains the signal added at the sensor port."""

    AT_ONCE = "at once"
    A_STEP_LATER = "a step later"
    NEVER = "never"


@dataclass(frozen=True, eq=False)
class RecordedNoise:
    """Fast noise of one recording.

    Attributes
    ----------
    signal : str
        Output that is the reading.
    corner : float
        [Hz] Frequency above which the noise is known.
    at_port : ndarray, shape (rows,)
        [FMU's unit] From each communication point on.
    to_si : float
        [SI / FMU's unit]
    showing : Showing
        When the simulated reading contains it.
    """

    signal: str
    corner: float
    at_port: Array
    to_si: float
    showing: Showing

    def logged(self, response: Response) -> Response:
        """Simulated readings with the noise in them, as the recorded ones have it."""
        if self.showing is Showing.AT_ONCE:
            return response
        lacking = self.at_port
        if self.showing is Showing.A_STEP_LATER:
            # The first reading precedes any added noise.
            lacking = lacking - np.concatenate([[0.0], lacking[:-1]])
        reading = response.held[self.signal] + self.to_si * lacking
        return replace(response, held={**response.held, self.signal: reading})

    def slow_part(self, change: Array, spacing: float) -> Array:
        """Part of a signal's change under the noise that is slower than the noise."""
        if self.corner >= _SLOWER / spacing:
            return np.zeros_like(change)  # the signal is sampled too slowly
        # A line through single rows would carry their noise into the slow part.
        few = max(1, min(change.size // 2, round(2.0 / (self.corner * spacing))))
        ends = float(np.mean(change[:few])), float(np.mean(change[-few:]))
        line = np.linspace(*ends, change.size)
        return np.asarray(change - _fast(change - line, spacing, self.corner))

    def with_more(self, lacking: Array, step: float) -> RecordedNoise:
        """Noise plus the fast part of a reading's remaining error [SI], shape (rows,)."""
        more = above(lacking, step, self.corner) / self.to_si
        return replace(self, at_port=self.at_port + more)


def above(column: Array, step: float, corner: float) -> Array:
    """Part of a column above a frequency, without a shift in time.

    Parameters
    ----------
    column : ndarray, shape (n,)
        Evenly sampled.
    step : float
        [s] Between samples.
    corner : float
        [Hz] Sharp, so that filtering twice equals filtering once, and no model gains by having
        its noise read more often.
    """
    line = np.linspace(column[0], column[-1], column.size)
    return _fast(column - line, step, corner)


def corner_of_noise(difference: Array, step: float, level: float) -> float | None:
    """Frequency above which a difference is white noise.

    Parameters
    ----------
    difference : ndarray, shape (n,)
        Recorded less simulated reading.
    step : float
        [s] Between samples.
    level : float
        Standard deviation of its noise near the Nyquist frequency.

    Returns
    -------
    float or None
        [Hz] None where the difference is white nowhere.
    """
    n = difference.size
    # The second difference keeps the slow part's leakage out of the fast bins.
    taper = np.hanning(n - 2)
    power = np.abs(np.fft.rfft(taper * np.diff(difference, 2))) ** 2 / np.sum(taper**2)
    frequency = np.fft.rfftfreq(n - 2, step)
    power = power / np.maximum((2.0 * np.sin(np.pi * frequency * step)) ** 4, 1e-30)
    found = None
    for corner in reversed(_CORNERS):
        if corner >= _SLOWER / step:
            continue
        band = (frequency >= corner) & (frequency < 1.5 * corner)
        if not np.any(band) or float(np.mean(power[band])) > _WHITE * level**2:
            break
        found = corner
    return found


def _fast(column: Array, step: float, corner: float) -> Array:
    kept = np.fft.rfftfreq(column.size, step) >= corner
    fast: Array = np.fft.irfft(np.fft.rfft(column) * kept, column.size)
    return fast


def under_noise(misfit: Misfit, model: Fitted) -> Hypothesis | None:
    """Add the noise of each recording to a model's hypothesis, if that explains more.

    Parameters
    ----------
    misfit : Misfit
        Recordings and budget.
    model : Fitted
        The noise is read from the residual of this model.
    """
    simulations, hypothesis = misfit.simulations, model.hypothesis
    if hypothesis.noise is not None:
        return None  # the noise was read with the model before this effect
    read = first_reading(simulations, model)
    first = replace(hypothesis, noise=tuple(read))
    if not any(read) or not _explains_more(misfit, model, first):
        return None
    noise = settled(simulations, model, read)
    found = replace(hypothesis, noise=tuple(noise))
    return found if any(noise) and _explains_more(misfit, model, found) else None


def first_reading(simulations: Simulations, model: Fitted) -> list[RecordedNoise | None]:
    """Read the fast noise of each recording's position, where the fast residual is only noise."""
    return [_read_about(simulations, model, k) for k in range(len(simulations.records))]


def settled(
    simulations: Simulations, model: Fitted, noise: Sequence[RecordedNoise | None]
) -> list[RecordedNoise | None]:
    """Subtract the axis' response to the noise; None where other signals contradict the noise.

    Parameters
    ----------
    simulations : Simulations
        Simulators of the twin.
    model : Fitted
        Model whose residual was read.
    noise : sequence of RecordedNoise or None
        As `first_reading` gives it.
    """
    return [
        None if own is None else _settled(simulations, model, k, own) for k, own in enumerate(noise)
    ]


def without_noise(simulations: Simulations, model: Fitted) -> Fitted:
    """Simulate a model without replayed noise.

    Parameters
    ----------
    simulations : Simulations
        Simulators of the twin.
    model : Fitted
        Of any hypothesis; returned as it is where no noise is played.
    """
    if model.hypothesis.noise is None:
        return model
    hypothesis = model.hypothesis.quiet
    simulated = simulations.run([hypothesis.point(model.x)])[0]
    return replace(model, hypothesis=hypothesis, simulated=simulated)


def _explains_more(misfit: Misfit, model: Fitted, noisy: Hypothesis) -> bool:
    """Whether noise changes a model's signals and, after a linear refit, lowers its chi2."""
    after = misfit.simulations.run_here(noisy.point(model.x))
    if not all(run.finite for run in after):
        return False
    if chi2(misfit.change(after, model.simulated)) <= _FELT:
        return False
    left = square_after_refit(misfit.residual(after), model.sensitivity, model.prior)
    return left < model.chi2


def _read_about(simulations: Simulations, model: Fitted, k: int) -> RecordedNoise | None:
    """Noise of one reading above the corner; None where the difference may be more than noise."""
    encoder = simulations.encoder
    if encoder is None or simulations.tracking is not None:
        return None
    record = simulations.records[k]
    base = model.simulated[k]
    if "sensor" not in base.response.ports:
        return None
    signal = next((s for s in record.signals if s.name == encoder.signal), None)
    difference = _difference(record, base.response, encoder.signal)
    if difference is None or signal is None:
        return None
    level = noise_level(signal, difference).total
    step = float(np.diff(record.plan.grid[:2])[0])
    corner = corner_of_noise(difference, step, level)
    if corner is None:
        return None
    column = above(difference, step, corner) / encoder.to_si
    if _is_transient(column * encoder.to_si, level):
        return None
    run = simulations.run_one(_point(model), k, excitation={"sensor": column})
    if not run.finite:
        return None
    change = run.response.held[encoder.signal] - base.response.held[encoder.signal]
    showing = _showing(change, column * encoder.to_si)
    return RecordedNoise(encoder.signal, corner, column, encoder.to_si, showing)


def _point(model: Fitted) -> Point:
    return model.hypothesis.quiet.point(model.x)


def _settled(
    simulations: Simulations, model: Fitted, k: int, noise: RecordedNoise
) -> RecordedNoise | None:
    """Noise with which the simulated reading equals the recorded one above the corner, or None.

    The recorded reading also contains the axis' response to the noise.
    """
    grid = simulations.records[k].plan.grid
    for _ in range(_ROUNDS):
        run = simulations.run_under(_point(model), k, noise)
        lacking = _difference(simulations.records[k], run.response, noise.signal)
        if lacking is None or not run.finite:
            return None
        before, noise = noise, noise.with_more(lacking, float(grid[1] - grid[0]))
        changed = float(np.std(noise.at_port - before.at_port))
        if changed < _SETTLED * float(np.std(noise.at_port)):
            break
    return noise if _is_felt(simulations, model, k, noise) else None


def _is_transient(column: Array, level: float) -> bool:
    """Whether an end holds more than noise, such as the transient of a start in motion."""
    few = max(8, round(_END * column.size))
    ends = (column[:few], column[-few:])
    return any(float(np.sqrt(np.mean(end**2))) > _TRANSIENT * level for end in ends)


def _is_felt(simulations: Simulations, model: Fitted, k: int, noise: RecordedNoise) -> bool:
    """Whether the other signals show the noise too; else only the logger saw it."""
    before = model.simulated[k]
    after = simulations.run_under(_point(model), k, noise)
    if not after.finite:
        return False
    signals = simulations.records[k].signals
    for signal, quiet, noisy in zip(signals, before.quiet, after.signals, strict=True):
        if signal.name == noise.signal or noise.corner >= _SLOWER / signal.spacing:
            continue
        left = [
            float(np.std(above(signal.values - values, signal.spacing, noise.corner)))
            for values in (quiet, noisy)
        ]
        if left[1] > _WORSE * left[0]:
            return False
    return True


def _showing(change: Array, noise: Array) -> Showing:
    size = float(noise @ noise)
    if float(change @ noise) > _CONTAINED * size:
        return Showing.AT_ONCE
    # The reading at t_k is made before the inputs of t_k act.
    before = np.concatenate([noise[:1], noise[:-1]])
    return Showing.A_STEP_LATER if float(change @ before) > _CONTAINED * size else Showing.NEVER


def _difference(record: Record, response: Response, position: str) -> Array | None:
    """Recorded less simulated reading at the communication points; None where rows differ."""
    recording, grid = record.plan.recording, record.plan.grid
    if recording.time.size != grid.size or not np.allclose(recording.time, grid, atol=1e-7):
        return None
    column = recording.signal(position)
    if not np.all(np.isfinite(column)):
        return None
    return np.asarray(column - response.held[position])
