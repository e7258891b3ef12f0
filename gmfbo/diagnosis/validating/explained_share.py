"""Share of what is more than noise on held-out stretches that laws explain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.evidence import weightings
from gmfbo.diagnosis.comparison.row_fits import is_more_than_noise
from gmfbo.diagnosis.result.explained import Share

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Squares:
    """Whitened squares of each held-out stretch, shape (n,).

    Attributes
    ----------
    noise : ndarray
        Expected of noise alone: the number of whitened values.
    before, after : ndarray
        Left by the twin with its parameters refitted, and with all that was named.
    without : mapping of str to ndarray
        Left without one of the named effects, refitted.
    """

    noise: Array
    before: Array
    after: Array
    without: Mapping[str, Array]

    def share(self, effect: str) -> Share | None:
        """What an effect explains: its own loss when it is dropped.

        Parameters
        ----------
        effect : str
            One of the named.

        Returns
        -------
        Share or None
            None where next to nothing is more than noise, or the loss is not known.
        """
        lost = self.without.get(effect)
        if lost is None:
            return None
        beyond, gone = self.before - self.noise, lost - self.after
        if not self._is_more_than_noise(beyond):
            return None
        weights = weightings(beyond.size)
        below = weights @ beyond
        if np.quantile(below, 0.025) <= 0.0:
            return None
        low, high = np.quantile((weights @ gone) / below, [0.025, 0.975])
        value = gone.sum() / beyond.sum()
        # Where the fit is as good as noise allows, a stretch may leave less than noise does.
        return Share(min(float(value), 1.0), min(float(low), 1.0), min(float(high), 1.0))

    @property
    def removed(self) -> float | None:
        """Share that is gone with all that was named; None where next to nothing is beyond noise.

        A fit may leave less than noise is expected to: then what it leaves is the floor.
        """
        beyond = self.before - self.noise
        if not self._is_more_than_noise(beyond):
            return None
        floor = min(float(self.noise.sum()), float(self.after.sum()))
        return float((self.before - self.after).sum() / (self.before.sum() - floor))

    @property
    def remainder(self) -> float | None:
        """Share that nothing explains; None where no more than noise is left."""
        beyond, left = self.before - self.noise, self.after - self.noise
        if not (self._is_more_than_noise(beyond) and self._is_more_than_noise(left)):
            return None
        return float(left.sum() / beyond.sum())

    @property
    def gain_nothing(self) -> bool:
        """Whether more than noise is left, and as much with what was named as without.

        A stretch counts by the share of it that is gone, as where nobody knows how large the noise
        in it is: of what is far beyond noise, the sum would be that of one stretch.
        """
        if self.remainder is None:
            return False
        return bool(self.noise @ np.log(self.after / self.before) >= 0.0)

    def _is_more_than_noise(self, beyond: Array) -> bool:
        return is_more_than_noise(float(beyond.sum()), float(self.noise.sum()))
