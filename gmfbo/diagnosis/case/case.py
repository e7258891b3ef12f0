"""Data shared by the steps of a diagnosis: twin, recordings and error budget."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Setting
from gmfbo.diagnosis.fitting.misfit import Misfit, chi2
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.covariances import whiteners
from gmfbo.diagnosis.scoring.noise_levels import NoiseLevel
from gmfbo.diagnosis.scoring.nuisances import Direction
from gmfbo.diagnosis.scoring.signal_parts import Rig
from gmfbo.diagnosis.scoring.whitening import Spectrum, Whitener, Window
from gmfbo.sources.twin.twin import FmuTwin

_MORE_THAN_NOISE = 1.06
"""Times the chi2 of noise; nulls of the blind benchmark have 0.84 to 1.00."""


@dataclass(frozen=True, eq=False)
class Budget:
    """Error budget: windows, their covariances and the nuisances, from which whiteners are made.

    Attributes
    ----------
    windows : tuple of Window
        Stretches that are scored.
    covariances : tuple of ndarray
        S(f) of each window.
    directions : tuple of lists of Direction
        Nuisances of each recording.
    loop_noise : tuple of lists of Direction
        How the sensor's noise, carried by the loop, changes each recording's signals.
    own_variances : tuple of lists of float
        [SI unit squared] Noise of each signal beyond the noise carried by the loop.
    noise_squares : tuple of float
        chi2 of each window by noise alone: less than its degrees of freedom, since S(f) also
        holds a tolerance.
    """

    windows: tuple[Window, ...]
    covariances: tuple[Spectrum, ...]
    directions: tuple[list[Direction], ...]
    loop_noise: tuple[list[Direction], ...]
    own_variances: tuple[list[float], ...]
    noise_squares: tuple[float, ...]

    @property
    def noise(self) -> float:
        """chi2 that noise alone gives in all windows."""
        return float(sum(self.noise_squares))

    @cached_property
    def plain(self) -> tuple[Whitener, ...]:
        """Whiteners by noise and tolerance, with no dispersion."""
        return self.whiteners()

    def whiteners(
        self, dispersion: Sequence[NDArray[np.float64]] | None = None
    ) -> tuple[Whitener, ...]:
        """Whiteners of all windows; a dispersion above one widens the budget."""
        return whiteners(self.windows, self.covariances, self.directions, dispersion)


@dataclass(eq=False)
class Case:
    """State shared by the steps of a diagnosis.

    Attributes
    ----------
    twin : FmuTwin
        The user's twin.
    simulations : Simulations
        Simulators that run the twin with physics at its ports.
    substeps : int
        Steps of physics in a communication step.
    rig : Rig
        Role of each signal.
    nominal : list of Simulated
        The recordings, simulated by the twin as it is.
    noise : dict of str to NoiseLevel
        Noise of each signal, over all recordings.
    budget : Budget
        Size of residuals that need no missing physics.
    misfit : Misfit
        Residuals whitened by that budget.
    setting : Setting
        Free parameters, and what the recordings show.
    base : Fitted
        The twin with its uncertain parameters refitted.
    notes : list of str
        Remarks for the reader.
    """

    twin: FmuTwin
    simulations: Simulations
    substeps: int
    rig: Rig
    nominal: list[Simulated]
    noise: dict[str, NoiseLevel]
    budget: Budget
    misfit: Misfit
    setting: Setting
    base: Fitted
    notes: list[str]

    @property
    def plain(self) -> Misfit:
        """Misfit whitened without dispersion, however imperfect the best model is."""
        return Misfit(self.simulations, self.budget.plain)

    def change_setting(self, setting: Setting) -> None:
        """Replace searched lines, bounds or scales; the refit stays as it is."""
        self.setting = setting
        hypothesis = replace(self.base.hypothesis, setting=setting)
        self.base = replace(self.base, hypothesis=hypothesis)

    def use(self, misfit: Misfit) -> None:
        """Whiten all residuals by another budget from here on."""
        self.misfit = misfit
        self.base = self.base.measured_by(misfit)


def dof(misfit: Misfit) -> int:
    """Number of whitened residuals."""
    return sum(w.n_residuals for w in misfit.whiteners)


def chi2_per_dof(fitted: Fitted, misfit: Misfit) -> float:
    """chi2 per degree of freedom: about one where the budget is right and nothing is missing."""
    return chi2(fitted.residual) / max(1, dof(misfit))


def times_noise(case: Case, model: Fitted) -> float:
    """Ratio of a model's chi2, without dispersion, to the chi2 that noise alone gives.

    Parameters
    ----------
    case : Case
        Twin, recordings and budget.
    model : Fitted
        The twin refitted, with or without named effects.
    """
    return model.measured_by(case.plain).chi2 / case.budget.noise


def is_more_than_noise(case: Case, model: Fitted) -> bool:
    """Whether a model's residual exceeds noise; see `times_noise`."""
    return times_noise(case, model) > _MORE_THAN_NOISE
