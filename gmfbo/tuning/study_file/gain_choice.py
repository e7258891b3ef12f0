"""Gains that a study tunes, and gains that it holds."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import InputError, StudyFileError, did_you_mean
from gmfbo.space import Gain, GainSpace
from gmfbo.tuning.study_file.study_sections import GainRange


@dataclass(frozen=True)
class GainChoice:
    """The tuned gains, and the values of the held gains.

    Attributes
    ----------
    space : GainSpace
        Box of the tuned gains.
    fixed : mapping of str to float
        Gains that the study holds [unit of the FMU parameter].
    """

    space: GainSpace
    fixed: Mapping[str, float]

    @classmethod
    def combine(
        cls,
        twin: GainSpace | None,
        study: Mapping[str, GainRange],
        parameters: Collection[str] = (),
    ) -> GainChoice:
        """Combine the study's ranges with the twin file's, which they override.

        Parameters
        ----------
        twin : GainSpace or None
            Box of the twin file.
        study : mapping of str to GainRange
            Part `[gains]` of the study file.
        parameters : collection of str
            FMU parameters, which a study may tune even if the twin file does not name them.

        Raises
        ------
        StudyFileError
            The twin does not know a gain, or none is left to tune.
        """
        known = {gain.name: gain for gain in twin.gains} if twin else {}
        if twin:
            for name in study:
                if name not in known and name not in parameters:
                    raise StudyFileError(
                        f"[gains]: no FMU parameter '{name}'"
                        + did_you_mean(name, {*known, *parameters})
                    )
        each = {name: rng.gain(name) for name, rng in study.items()}
        fixed = {name: gain for name, gain in each.items() if not isinstance(gain, Gain)}
        chosen = {name: gain for name, gain in each.items() if isinstance(gain, Gain)}
        free = [chosen.get(name, known.get(name)) for name in {**known, **chosen}]
        gains = tuple(gain for gain in free if gain is not None and gain.name not in fixed)
        if not gains:
            raise StudyFileError("[gains]: nothing to tune; give at least one gain = [low, high]")
        return cls(space=GainSpace(gains), fixed=fixed)

    def values(self, point: NDArray[np.float64]) -> dict[str, float]:
        """All gains by name at a point of the box, shape (d,)."""
        return {**self.space.named(point), **self.fixed}

    def point(self, gains: Mapping[str, float]) -> NDArray[np.float64]:
        """Point of the box, shape (d,), from all gains by name."""
        return self.space.point({name: gains[name] for name in self.space.names})

    def check_fixed(self, fixed: Mapping[str, float], *, label: str = "fixed") -> None:
        """Raise for values outside the box.

        Parameters
        ----------
        fixed : mapping of str to float
            Gains to be held in the next proposals.
        label : str
            Name of the values, for messages.

        Raises
        ------
        InputError
            A gain is unknown or its value outside its range.
        """
        ranges = {gain.name: gain for gain in self.space.gains}
        for name, value in fixed.items():
            if name not in ranges:
                raise InputError(f"{label}: no tuned gain '{name}'" + did_you_mean(name, ranges))
            low, high = ranges[name].low, ranges[name].high
            if not low <= value <= high:
                raise InputError(
                    f"{label}: expected '{name}' within [{low:g}, {high:g}], got {value:g}"
                )
            steps = ranges[name].steps
            if steps is not None and not np.isclose(steps, value, rtol=1e-6).any():
                shown = ", ".join(f"{one:g}" for one in steps[:8]) + (
                    " ..." if len(steps) > 8 else ""
                )
                raise InputError(f"{label}: expected '{name}' to be one of {shown}, got {value:g}")
