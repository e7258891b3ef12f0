"""Errors on held-out recordings, before and after."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

_LEAST_REMOVED = 0.01  # of the explainable error on held-out recordings
_MOSTLY_REMOVED = 0.5  # of it: such physics is there, whatever is left at its edges
_BEYOND_NOISE, _WORSE = 1.5, 1.1  # times the noise floor; times the error without the physics


@dataclass(frozen=True)
class SignalFit:
    """NRMSE of one signal on the held-out recordings: RMS error over the recorded range.

    All are dimensionless and least is best; NaN where there is no such model.

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
        What a perfect twin would leave.
    """

    nominal: float
    parameters_only: float
    augmented: float
    unnamed_spline: float
    noise_floor: float


@dataclass(frozen=True)
class Fit:
    """Errors of the twin before and after, by parameters that never saw the scored recordings.

    Attributes
    ----------
    fitted_on : tuple of str
        Recordings that the parameters were fitted on; the same values are in `augmented.fmu`.
    held_out : tuple of str
        Recordings that were scored.
    signals : mapping of str to SignalFit
        Errors by signal.
    explainable_error_removed : float or None
        Share of what physics could explain that the named physics does explain, in the weighted
        norm of the decision; None where there is next to nothing to explain.
    """

    fitted_on: tuple[str, ...]
    held_out: tuple[str, ...]
    signals: Mapping[str, SignalFit]
    explainable_error_removed: float | None = None

    @property
    def removes_nothing(self) -> bool:
        """Whether the physics removes next to nothing of an error that physics could explain."""
        removed = self.explainable_error_removed
        return removed is not None and removed < _LEAST_REMOVED

    @property
    def is_worse(self) -> bool:
        """Whether RMS errors on recordings that no fit has seen are clearly larger with physics.

        They are in units of the noise floor, over all signals alike.
        """
        before, after = self.in_noise_floors
        return after > _BEYOND_NOISE and after > _WORSE * before

    @property
    def in_noise_floors(self) -> tuple[float, float]:
        """RMS error without and with the physics; NaN where there is none to compare."""
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
    """Whether recordings that no fit has seen speak against the physics.

    A law that holds leaves little more than noise; one that merely bent to the fitted recordings
    misses these by more than no law at all. Where an axis comes to rest within its friction or its
    gap is chance, though, and counts in an RMS error as long as the rest lasts: physics that takes
    most of the explainable error away stands, and where there is next to nothing to explain, so
    does physics by which the weighted error falls. A limit that these recordings never reach says
    nothing about them: their errors then differ by how far an axis drifts alone.

    Parameters
    ----------
    fit : Fit
        Errors on those recordings.
    falls : bool
        Whether the error in the weighted norm of the decision is clearly smaller with the physics.
    differs : bool
        Whether in that norm it makes a difference here at all.
    """
    if not differs or not fit.in_noise_floors[1] > _BEYOND_NOISE:
        return False
    removed = fit.explainable_error_removed
    stands = falls if removed is None else removed > _MOSTLY_REMOVED
    return fit.removes_nothing or (fit.is_worse and not stands)
