"""Errors on held-out recordings, before and after."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

_LEAST_REMOVED = 0.01  # of the explainable error on held-out recordings
_MOSTLY_REMOVED = 0.5  # of the explainable error: then the physics stands, whatever error remains
_BEYOND_NOISE, _WORSE = 1.5, 1.1  # times the noise floor; times the error without the physics


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
        The twin with the named physics and refitted parameters.
    unnamed_spline : float
        The refitted twin with a smooth residual that has no name.
    noise_floor : float
        Error of a perfect twin, by noise alone.
    """

    nominal: float
    parameters_only: float
    augmented: float
    unnamed_spline: float
    noise_floor: float


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
        Share of the explainable error that the named physics removes, in the weighted norm of the
        decision; None where there is next to nothing to explain.
    """

    fitted_on: tuple[str, ...]
    held_out: tuple[str, ...]
    signals: Mapping[str, SignalFit]
    explainable_error_removed: float | None = None

    @property
    def removes_nothing(self) -> bool:
        """Whether the physics removes next to nothing of the explainable error."""
        removed = self.explainable_error_removed
        return removed is not None and removed < _LEAST_REMOVED

    @property
    def is_worse(self) -> bool:
        """Whether RMS errors on held-out recordings are clearly larger with the physics.

        Errors are in units of the noise floor, as root mean square over the signals.
        """
        before, after = self.in_noise_floors
        return after > _BEYOND_NOISE and after > _WORSE * before

    @property
    def in_noise_floors(self) -> tuple[float, float]:
        """RMS error without and with the physics, over the noise floor; NaN where none compares."""
        pairs = [
            (fit.parameters_only / fit.noise_floor, fit.augmented / fit.noise_floor)
            for fit in self.signals.values()
            if fit.noise_floor > 0.0
        ]
        if not self.held_out or not pairs:
            return math.nan, math.nan
        before, after = (
            math.sqrt(sum(x**2 for x in column) / len(pairs)) for column in zip(*pairs, strict=True)
        )
        return before, after

    @property
    def most_improved(self) -> str | None:
        """Signal whose error the physics reduces most, in points of NRMSE; None without one."""
        falls = {
            name: fit.parameters_only - fit.augmented
            for name, fit in self.signals.items()
            if fit.augmented < fit.parameters_only
        }
        return max(falls, key=lambda name: falls[name]) if falls else None


def contradicts_names(fit: Fit, *, falls: bool, differs: bool) -> bool:
    """Whether held-out recordings contradict the named physics.

    A right law leaves little more than noise; an overfitted law makes the held-out error larger
    than no law does. But the place where an axis comes to rest within its friction or gap is
    chance, and counts in an RMS error as long as the rest lasts. So physics stands that removes
    most of the explainable error, or, where little is explainable, lowers the weighted error.
    A limit that these recordings never reach makes no prediction about them: their errors then
    differ only by the drift of the axis.

    Parameters
    ----------
    fit : Fit
        Errors on those recordings.
    falls : bool
        Whether the error in the weighted norm of the decision is clearly smaller with the physics.
    differs : bool
        Whether the physics makes a difference in that norm on these recordings.
    """
    if not differs or not fit.in_noise_floors[1] > _BEYOND_NOISE:
        return False
    removed = fit.explainable_error_removed
    stands = falls if removed is None else removed > _MOSTLY_REMOVED
    return fit.removes_nothing or (fit.is_worse and not stands)
