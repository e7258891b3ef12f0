"""Error budgets of a case: before the loop's noise is known, and measured about a fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gmfbo.diagnosis.case.case import Budget
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.noise.loop_noise import own_variances, white_variances
from gmfbo.diagnosis.noise.measured_noise import noise_through_loop
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.covariances import covariances, noise_squares, whiteners
from gmfbo.diagnosis.scoring.noise_levels import NoiseLevel, noise_levels
from gmfbo.diagnosis.scoring.nuisances import Direction, nuisance_directions
from gmfbo.diagnosis.scoring.signal_parts import Rig
from gmfbo.diagnosis.scoring.whitening import Window
from gmfbo.sources.twin.twin import FmuTwin


def measured_budget(
    twin: FmuTwin,
    simulations: Simulations,
    windows: tuple[Window, ...],
    rig: Rig,
    base: Fitted,
    ratio: float,
    rng: np.random.Generator,
) -> Budget:
    """Measure noise, nuisances and what the loop makes of them about a fit.

    Parameters
    ----------
    twin : FmuTwin
        The user's.
    simulations : Simulations
        Simulators of the twin.
    windows : tuple of Window
        Stretches that are scored.
    rig : Rig
        Role of each signal.
    base : Fitted
        The twin with its uncertain parameters refitted.
    ratio : float
        Torque that one unit of command balances.
    rng : numpy Generator
        Of the noise runs.
    """
    noise = noise_levels(simulations.records, base.simulated)
    point = base.hypothesis.point(base.x)
    through = noise_through_loop(twin, simulations, windows, base, rig, noise, rng)
    own = [
        own_variances(record, levels, changes, run, rig.position)
        for record, levels, changes, run in zip(
            simulations.records, noise, through, base.simulated, strict=True
        )
    ]
    spectra = covariances(windows, simulations.records, rig, own, through)
    directions = nuisance_directions(simulations, point, base.simulated, rig.alignments, ratio)
    squares = noise_squares(windows, simulations.records, rig, spectra)
    return Budget(windows, tuple(spectra), tuple(directions), tuple(through), tuple(own), squares)


def without_loop_noise(
    simulations: Simulations,
    windows: Sequence[Window],
    rig: Rig,
    noise: Sequence[dict[str, NoiseLevel]],
) -> Misfit:
    """Residuals by a budget in which each signal's noise is its own, before more is known."""
    empty: list[list[Direction]] = [[] for _ in simulations.records]
    own = [white_variances(r, levels) for r, levels in zip(simulations.records, noise, strict=True)]
    spectra = covariances(windows, simulations.records, rig, own, empty)
    return Misfit(simulations, whiteners(windows, spectra, empty))
