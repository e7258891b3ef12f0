"""Whether what a model leaves grows and shrinks with the motion.

Noise of whatever colour is as large while the axis rests as while it moves fast; what a model
lacks is not. So the energy of the whitened residual in short stretches is ranked against speed,
acceleration and command, and the rank correlation (Spearman 1904) is held against what the same
energies give when they are turned in time against the motion, which keeps their colour.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.diagnosis.scoring.whitening import Whitener

Array = NDArray[np.float64]

_STRETCH = 0.025  # [s] over which the energy is averaged
_FEWEST = 8  # stretches of a window
_TURNS = 999


def chance_of_moving(case: Case, model: Fitted, rng: np.random.Generator) -> float:
    """How often noise would follow the motion as much as what a model leaves does.

    Returns
    -------
    float
        Probability of the largest of the three correlations, in units of their spreads; 1 where
        windows are too short to tell.
    """
    energies, motions = [], []
    for whitener in case.budget.plain:
        energy, motion = _stretches(case, model, whitener)
        if energy.size >= _FEWEST:
            energies.append(energy)
            motions.append(motion)
    if not energies:
        return 1.0
    motion = np.stack([rankdata(row) for row in np.concatenate(motions, axis=1)])
    motion = motion - motion.mean(axis=1, keepdims=True)
    sizes = np.sqrt(np.sum(motion**2, axis=1))

    def correlation(turns: list[int]) -> Array:
        turned = [np.roll(energy, turn) for energy, turn in zip(energies, turns, strict=True)]
        ranks = rankdata(np.concatenate(turned))
        ranks = ranks - ranks.mean()
        found: Array = motion @ ranks / np.maximum(sizes * np.sqrt(ranks @ ranks), 1e-300)
        return found

    here = correlation([0] * len(energies))
    chance = np.array(
        [correlation([int(rng.integers(e.size)) for e in energies]) for _ in range(_TURNS)]
    )
    spread = np.maximum(chance.std(axis=0), 1e-300)
    off = np.max(np.abs(chance - chance.mean(axis=0)) / spread, axis=1)
    found = np.max(np.abs(here - chance.mean(axis=0)) / spread)
    return float((np.count_nonzero(off >= found) + 1) / (_TURNS + 1))


def _stretches(case: Case, model: Fitted, whitener: Whitener) -> tuple[Array, Array]:
    """Energy of each stretch of a window, and speed, acceleration and command there."""
    window = whitener.window
    record, run = case.simulations.records[window.record], model.simulated[window.record]
    left = [s.values - values for s, values in zip(record.signals, run.signals, strict=True)]
    white = whitener.colour(window.spectra(left))
    place = int(np.argmin([s.spacing for s in record.signals]))
    rows = window.rows[place]
    time = record.signals[place].time[rows]
    energy = np.sum(np.fft.irfft(white, time.size, axis=0) ** 2, axis=1)
    states = states_of(run, record)
    grid = record.plan.grid
    velocity = np.interp(time, grid, states.velocity)
    command = np.interp(time, grid, states.command)
    shown = np.abs([velocity, np.gradient(velocity, time), command])
    few = max(1, round(_STRETCH / record.signals[place].spacing))
    count = time.size // few
    cut = slice(0, count * few)
    # The window's taper takes the first and the last stretch.
    return (
        energy[cut].reshape(count, few).mean(axis=1)[1:-1],
        shown[:, cut].reshape(3, count, few).mean(axis=2)[:, 1:-1],
    )
