"""Errors on held-out recordings, before and after."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from gmfbo.diagnosis.result.explained import FreeRun

_CHANCE = 0.1  # of a noise floor: what a refit may lose by chance


@dataclass(frozen=True)
class SignalFit:
    """NRMSE of one signal on the held-out recordings: RMS error over the recorded range.

    All are dimensionless, and smaller is better; NaN where there is no such model.

    Attributes
    ----------
    nominal : float
        The twin as it came.
    parameters_only : float
        The twin with its uncertain parameters refitted.
    augmented : float
        The twin with the named physics, with fixed parameters that are wrong put right, and with
        refitted ones.
    unnamed_spline : float
        The twin with a free function in place of laws, or beside some, and refitted parameters.
    noise_floor : float
        Error of a perfect twin, by noise alone.
    free_run : FreeRun or None
        The same over whole recordings without correction, of an open-loop twin.
    """

    nominal: float
    parameters_only: float
    augmented: float
    unnamed_spline: float
    noise_floor: float
    free_run: FreeRun | None = None

    @property
    def is_worse(self) -> bool:
        """Whether the twin that is told meets this signal worse than the one that came.

        By more than chance: of a twin that lacks nothing any refit changes its errors.
        """
        told = self.augmented if math.isfinite(self.augmented) else self.parameters_only
        return told > self.nominal + self._by_chance

    @property
    def is_worse_with_physics(self) -> bool:
        """Whether the named physics meets this signal worse than refitted parameters alone."""
        return self.augmented > self.parameters_only + self._by_chance

    @property
    def _by_chance(self) -> float:
        return _CHANCE * self.noise_floor if math.isfinite(self.noise_floor) else 0.0


@dataclass(frozen=True)
class Fit:
    """Errors of the twin before and after, with parameters fitted to other recordings.

    Attributes
    ----------
    fitted_on : tuple of str
        Recordings that the parameters were fitted on; the same values are in `augmented.fmu`.
    held_out : tuple of str
        Recordings that were scored.
    signals : mapping of str to SignalFit
        Errors by signal.
    explainable_error_removed : float or None
        Share of the explainable error that the named physics removes, in the norm of noise alone,
        as `share`; None where there is next to nothing to explain.
    log_density_gain, gain_error : float or None
        [nats] By how much the held-out recordings are likelier by the model than by the refitted
        twin, and the standard error of that over stretches. None where nothing is named, and in
        diagnoses made before it was told.
    twin_is_withheld : bool
        Whether no corrected twin is handed back, since these recordings prefer it as it came.
    """

    fitted_on: tuple[str, ...]
    held_out: tuple[str, ...]
    signals: Mapping[str, SignalFit]
    explainable_error_removed: float | None = None
    log_density_gain: float | None = None
    gain_error: float | None = None
    twin_is_withheld: bool = False

    @property
    def most_improved(self) -> str | None:
        """Signal whose error the physics reduces most, in points of NRMSE; None without one."""
        falls = {
            name: fit.parameters_only - fit.augmented
            for name, fit in self.signals.items()
            if fit.augmented < fit.parameters_only
        }
        return max(falls, key=lambda name: falls[name]) if falls else None
