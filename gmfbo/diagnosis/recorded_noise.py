"""The fast noise that a controller saw, read off the recording and played into the twin.

Noise of an encoder reaches the motor through the controller. It shakes the axis loose of small
friction and bridges small dead zones, so that a twin run without it shows another axis; and what
of it can be predicted need not hide anything. Its slow part cannot be told from motion and stays
in the budget.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.budget import NoiseLevel
from gmfbo.diagnosis.fitting import Fitted
from gmfbo.diagnosis.records import Record
from gmfbo.diagnosis.simulations import PlayedNoise, Point, Simulated, Simulations
from gmfbo.diagnosis.whitening import Spectrum, Window
from gmfbo.sources.augmented import Response

Array = NDArray[np.float64]

_CORNERS = (30.0, 45.0, 65.0, 95.0, 140.0, 200.0)  # [Hz] above which noise is played
_WHITE = 1.6  # times the level near the Nyquist frequency: more is motion
_SMEARED = 0.97  # of the corner: a window's taper spreads it
_ROUNDS = 7  # of reading the noise at most, each beside what the axis makes of the last
_SETTLED = 0.01  # of the noise, by which a further round changes it
_CONTAINED = 0.5  # of the sensor port's noise, which a reading holds that contains the port
_END = 0.02  # of a recording, at each end
_TRANSIENT = 4.0  # times the level, which noise at the ends does not reach
_WORSE = 1.1  # times a signal's fast residual, which playing what the motor felt does not reach


class Showing(Enum):
    """When a simulated reading holds what is added at the sensor port."""

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
        [Hz] Above which it is known.
    at_port : ndarray, shape (rows,)
        [FMU's unit] From each communication point on.
    to_si : float
        [SI / FMU's unit]
    showing : Showing
        Whether the simulated reading holds it already.
    """

    signal: str
    corner: float
    at_port: Array
    to_si: float
    showing: Showing

    def logged(self, response: Response) -> Response:
        """Let the simulated reading hold it, as the recorded one does."""
        if self.showing is Showing.AT_ONCE:
            return response
        lacking = self.at_port
        if self.showing is Showing.A_STEP_LATER:
            # Nothing was added before the first reading was made.
            lacking = lacking - np.concatenate([[0.0], lacking[:-1]])
        reading = response.held[self.signal] + self.to_si * lacking
        return replace(response, held={**response.held, self.signal: reading})

    def slow_part(self, column: Array, step: float) -> Array:
        """What of other noise lies below the corner, and is not played."""
        return column - above(column, step, self.corner)

    def with_more(self, lacking: Array, step: float) -> RecordedNoise:
        """Return it with the fast part of what a reading still lacks [SI], shape (rows,)."""
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
        [Hz] A sharp one: what is taken twice is taken once, so that no model gains by having had
        its noise read more often.
    """
    line = np.linspace(column[0], column[-1], column.size)
    kept = np.fft.rfftfreq(column.size, step) >= corner
    fast: Array = np.fft.irfft(np.fft.rfft(column - line) * kept, column.size)
    return fast


def noise_of(
    simulations: Simulations,
    point: Point,
    base: Sequence[Simulated],
    position: str | None,
    position_to_si: float,
    noise: Sequence[dict[str, NoiseLevel]],
) -> list[RecordedNoise | None]:
    """Read the fast noise of each recording's position, where it is nothing but noise.

    Parameters
    ----------
    simulations : Simulations
        Who runs the twin.
    point : Point
        Where.
    base : sequence of Simulated
        The recordings simulated there.
    position : str or None
        Output that is the recorded position.
    position_to_si : float
        [SI / FMU's unit]
    noise : sequence of mapping of str to NoiseLevel
        White noise of each signal, for each recording.
    """
    nothing: list[RecordedNoise | None] = [None] * len(base)
    if position is None or simulations.tracking is not None:
        return nothing
    if "sensor" not in base[0].response.ports:
        return nothing

    def one(k: int) -> RecordedNoise | None:
        record, level = simulations.records[k], noise[k].get(position)
        difference = _difference(record, base[k].response, position)
        if difference is None or level is None:
            return None
        step = float(np.diff(record.plan.grid[:2])[0])
        corner = _corner(difference, step, level.total)
        if corner is None:
            return None
        column = above(difference, step, corner) / position_to_si
        if _is_transient(column * position_to_si, level.total):
            return None
        run = simulations.run_one(point, k, excitation={"sensor": column})
        if not run.finite:
            return None
        change = run.response.held[position] - base[k].response.held[position]
        showing = _showing(change, column * position_to_si)
        found = RecordedNoise(position, corner, column, position_to_si, showing)
        settled = _settled(simulations, point, k, found)
        if settled is None or not _is_felt(simulations, point, k, settled, base[k]):
            return None
        return settled

    return simulations.map(one, range(len(base)))


def renewed(simulations: Simulations, model: Fitted) -> tuple[PlayedNoise | None, ...] | None:
    """Read the noise once more, about another model; None where none is played.

    What a model without an effect cannot explain of the fast part is no noise: each hypothesis
    brings its own.

    Parameters
    ----------
    simulations : Simulations
        Who runs the twin.
    model : Fitted
        With the noise that was played until now.
    """
    known = model.hypothesis.noise or tuple(simulations.noise)
    if not any(isinstance(noise, RecordedNoise) for noise in known):
        return None
    point = model.hypothesis.point(model.x)
    found: list[PlayedNoise | None] = []
    for k, noise in enumerate(known):
        if isinstance(noise, RecordedNoise):
            again = _settled(simulations, point, k, noise)
            if again is None:
                return None
            noise = again
        found.append(noise)
    return tuple(found)


def without_noise(simulations: Simulations, model: Fitted) -> Fitted:
    """Return the same model as its FMU runs, without the noise of the recordings played into it.

    Parameters
    ----------
    simulations : Simulations
        Who runs the twin.
    model : Fitted
        Of any hypothesis; returned as it is where no noise is played.
    """
    if not any(noise is not None for noise in simulations.noise):
        return model
    with simulations.quiet():
        simulated = simulations.run([model.hypothesis.point(model.x)])[0]
    return replace(model, simulated=simulated)


def _settled(
    simulations: Simulations, point: Point, k: int, noise: RecordedNoise
) -> RecordedNoise | None:
    """Noise with which the simulated reading is as fast as the recorded one; None if it fails.

    What the axis makes of the noise is in the recorded reading as well.
    """
    grid = simulations.records[k].plan.grid
    for _ in range(_ROUNDS):
        played = (None,) * k + (noise,)
        run = simulations.run_one(replace(point, noise=played), k)
        lacking = _difference(simulations.records[k], run.response, noise.signal)
        if lacking is None or not run.finite:
            return None
        before, noise = noise, noise.with_more(lacking, float(grid[1] - grid[0]))
        changed = float(np.std(noise.at_port - before.at_port))
        if changed < _SETTLED * float(np.std(noise.at_port)):
            break
    return noise


def _is_transient(column: Array, level: float) -> bool:
    """Whether one end holds more than noise: a start in motion, which the twin has to forget."""
    few = max(8, round(_END * column.size))
    ends = (column[:few], column[-few:])
    return any(float(np.sqrt(np.mean(end**2))) > _TRANSIENT * level for end in ends)


def _is_felt(
    simulations: Simulations, point: Point, k: int, noise: RecordedNoise, before: Simulated
) -> bool:
    """Whether the other signals agree: what only the logger or one of two encoders saw is none."""
    played = (None,) * k + (noise,)
    after = simulations.run_one(replace(point, noise=played), k)
    if not after.finite:
        return False
    signals = simulations.records[k].signals
    for signal, quiet, noisy in zip(signals, before.signals, after.signals, strict=True):
        if signal.name == noise.signal or noise.corner >= 0.3 / signal.spacing:
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


def played_spectrum(noise: RecordedNoise, window: Window, signal: int, variance: float) -> Spectrum:
    """Covariance of the reading's noise in the band that is played: there nothing is claimed.

    Parameters
    ----------
    noise : RecordedNoise
        What is played.
    window : Window
        What is scored.
    signal : int
        Place of the reading among its signals.
    variance : float
        [SI unit squared] Of the reading's noise.
    """
    variances = np.zeros(window.n_signals)
    variances[signal] = variance
    kept = window.frequencies >= _SMEARED * noise.corner
    white = window.white([float(v) for v in variances])
    spectrum = np.zeros((kept.size, window.n_signals, window.n_signals), dtype=complex)
    spectrum[:, signal, signal] = kept * white[..., signal]
    return spectrum


def _difference(record: Record, response: Response, position: str) -> Array | None:
    """Recorded less simulated reading at the communication points; None where rows differ."""
    recording, grid = record.plan.recording, record.plan.grid
    if recording.time.size != grid.size or not np.allclose(recording.time, grid, atol=1e-7):
        return None
    column = recording.signal(position)
    if not np.all(np.isfinite(column)):
        return None
    return np.asarray(column - response.held[position])


def _corner(difference: Array, step: float, level: float) -> float | None:
    """Frequency above which a difference is as white as near the Nyquist frequency."""
    n = difference.size
    # The second difference keeps the slow part's leakage out of the fast bins.
    taper = np.hanning(n - 2)
    power = np.abs(np.fft.rfft(taper * np.diff(difference, 2))) ** 2 / np.sum(taper**2)
    frequency = np.fft.rfftfreq(n - 2, step)
    power = power / np.maximum((2.0 * np.sin(np.pi * frequency * step)) ** 4, 1e-30)
    found = None
    for corner in reversed(_CORNERS):
        if corner >= 0.3 / step:
            continue
        band = (frequency >= corner) & (frequency < 1.5 * corner)
        if not np.any(band) or float(np.mean(power[band])) > _WHITE * level**2:
            break
        found = corner
    return found
