"""Map proposals to the nearest recorded gains that are not replayed yet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import InputError, StudyFileError
from gmfbo.sources.plants.recorded_grid import SAME, RecordedGrid
from gmfbo.tuning.study_file.gain_choice import GainChoice


@dataclass(frozen=True)
class RecordedChoice:
    """Recorded gains that a study may ask for.

    A proposal becomes the nearest recorded gains not replayed yet, by distance in the unit cube
    of the tuned gains. Nothing is interpolated.

    Attributes
    ----------
    grid : RecordedGrid
        Recordings within the box, at the values of the gains that the study fixes.
    gains : GainChoice
        Tuned and held gains.
    """

    grid: RecordedGrid
    gains: GainChoice

    @classmethod
    def within(cls, grid: RecordedGrid, gains: GainChoice) -> Self:
        """Keep the recordings that belong to a study.

        Raises
        ------
        StudyFileError
            No recording belongs to the study, or a recording does not state its gains.
        """
        low, high = gains.space.bounds
        slack = SAME * np.maximum(np.abs(low), np.abs(high))
        known = grid.knowing([*gains.space.names])
        fixed = [run.made_at(gains.fixed) for run in grid.runs]
        kept = []
        for run, agrees in zip(known.runs, fixed, strict=True):
            point = gains.space.point(run.gains)
            if agrees and np.all((point >= low - slack) & (point <= high + slack)):
                kept.append(run)
        if not kept:
            box = ", ".join(f"{g.name} = [{g.low:g}, {g.high:g}]" for g in gains.space.gains)
            raise StudyFileError(
                f"[is1] recorded: none of the {len(grid.runs)} recordings in {grid.folder} was "
                f"made within {box}; widen [gains] or name another folder"
            )
        return cls(RecordedGrid(grid.folder, tuple(kept), grid.reading, grid.content_hash), gains)

    def nearest(
        self,
        unit: NDArray[np.float64],
        played: Sequence[Mapping[str, float]],
        held: Mapping[str, float],
    ) -> dict[str, float]:
        """Gains of the nearest recording not replayed yet.

        Parameters
        ----------
        unit : ndarray, shape (d,)
            Proposal in the unit cube.
        played : sequence of mapping of str to float
            Gains of the real runs so far.
        held : mapping of str to float
            Gains that must have these values.

        Raises
        ------
        InputError
            No recording is left at the held values.
        """
        left = [run for run in self.grid.left(played) if run.made_at(held)]
        if not left:
            wanted = ", ".join(f"{name} = {value:g}" for name, value in held.items())
            raise InputError(f"{self.grid.name}: no recording is left at {wanted}; hold another")
        points = np.stack([self.gains.space.point(run.gains) for run in left])
        distance = np.linalg.norm(self.gains.space.to_unit(points) - unit, axis=1)
        return self.gains.values(points[int(np.argmin(distance))])

    def used_up(self, played: Sequence[Mapping[str, float]]) -> bool:
        """Whether every recording was replayed."""
        return not self.grid.left(played)
