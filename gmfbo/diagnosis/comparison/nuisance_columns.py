"""What every logger does to a column: clock, lateness, scale, zero and filter, for all recordings.

Each has a standard normal coordinate. That of a filter bends upward, so that filters of several
rows are unlikely, and no more than that. Where stamps jitter, one tells whether the rows did (0) or
the stamps alone (1), on a logger that samples evenly and looks at its clock some time later.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from gmfbo.diagnosis.comparison.numbers import (
    CLOCK_PRIOR,
    LOW_PASS_SHARE,
    OFFSET_PRIOR,
    POSITION_SCALE_PRIOR,
    SCALE_PRIOR,
    SHIFT_SHARE,
)
from gmfbo.diagnosis.comparison.segments import Segment
from gmfbo.diagnosis.scoring.nuisances import Alignment

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Logging:
    """Small errors of the logger, common to all recordings.

    Attributes
    ----------
    names : tuple of (str, str)
        Kind and signal of each of the q errors.
    ranges : mapping of str to float
        [SI] Of each recorded signal.
    resolutions : mapping of str to float
        [SI] Steps in which it is rounded; 0 where it is not.
    positions : frozenset of str
        Signals in the position's unit.
    alignments : mapping of str to Alignment
        Priors by signal, as the twin file widens them.
    """

    names: tuple[tuple[str, str], ...]
    ranges: Mapping[str, float]
    resolutions: Mapping[str, float]
    positions: frozenset[str]
    alignments: Mapping[str, Alignment]

    @property
    def one_sided(self) -> NDArray[np.bool_]:
        """Errors that have no sign: a filter's time constant, shape (q,)."""
        return np.array([kind == "filter" for kind, _ in self.names], dtype=bool)

    def seen(self, segment: Segment, values: Array, nuisances: Array) -> Array:
        """Signals as the logger stores them, shape (m, n).

        Parameters
        ----------
        segment : Segment
            A stretch of a recording.
        values : ndarray, shape (m, n)
            [SI] As they are.
        nuisances : ndarray, shape (q,)
            [standard deviations]
        """
        total = values.copy()
        rates = _rates(segment, values)
        for (kind, name), nu in zip(self.names, nuisances, strict=True):
            if nu == 0.0 or (name and name not in segment.names):
                continue
            rows = [segment.names.index(name)] if name else list(range(len(values)))
            for row in rows:
                column, rate = values[row], rates[row]
                total[row] += self._change(kind, name, segment, column, rate, float(nu))
        return total

    def slopes(self, segment: Segment, values: Array, nuisances: Array) -> Array:
        """Change of the stored signals per unit of each error, shape (q, m, n).

        Parameters
        ----------
        segment, values, nuisances
            As of `seen`.
        """
        columns = np.zeros((len(self.names), *values.shape))
        rates = _rates(segment, values)
        for i, ((kind, name), nu) in enumerate(zip(self.names, nuisances, strict=True)):
            if name and name not in segment.names:
                continue
            rows = [segment.names.index(name)] if name else list(range(len(values)))
            for row in rows:
                column, rate = values[row], rates[row]
                columns[i, row] = self._slope(kind, name, segment, column, rate, float(nu))
        return columns

    def _change(
        self, kind: str, name: str, segment: Segment, column: Array, rate: Array, nu: float
    ) -> Array:
        if kind == "filter":
            time = LOW_PASS_SHARE * segment.spacing * np.expm1(nu)
            return _filtered(column, time, segment.spacing) - column
        return nu * self._slope(kind, name, segment, column, rate, 0.0)

    def _slope(
        self, kind: str, name: str, segment: Segment, column: Array, rate: Array, nu: float
    ) -> Array:
        if kind == "clock":
            since = segment.time - segment.times[0][0]
            drift: Array = CLOCK_PRIOR * since * rate
            return drift
        if kind == "stamps":
            return np.asarray(-segment.late * rate, dtype=np.float64)
        if kind == "scale":
            usual = POSITION_SCALE_PRIOR if name in self.positions else SCALE_PRIOR
            return max(usual, self.alignments[name].scale) * column
        if kind == "offset":
            return np.full(column.size, self._offset(name))
        if kind == "shift":
            return (self.alignments[name].shift or SHIFT_SHARE * segment.spacing) * rate
        size = LOW_PASS_SHARE * segment.spacing
        time = size * np.expm1(nu)
        twice = _filtered(_filtered(rate, time, segment.spacing), time, segment.spacing)
        slope: Array = -size * np.exp(nu) * twice
        return slope

    def _offset(self, name: str) -> float:
        """Zeros of positions and commands are the twin's own, but for how counts are rounded."""
        stated = self.alignments[name].offset
        if name in self.positions or not stated:
            return max(0.5 * self.resolutions[name], stated)
        return max(OFFSET_PRIOR * self.ranges[name], stated * self.ranges[name])


def logging_of(
    segments: Sequence[Segment],
    ranges: Mapping[str, float],
    resolutions: Mapping[str, float],
    positions: frozenset[str],
    alignments: Mapping[str, Alignment],
) -> Logging:
    """State the errors that a logger may have made.

    Parameters
    ----------
    segments : sequence of Segment
        Stretches that are compared.
    ranges, resolutions, positions, alignments
        As of `Logging`.
    """
    found: list[tuple[str, str]] = []
    for name in dict.fromkeys(name for s in segments for name in s.names):
        found += [("shift", name), ("filter", name), ("scale", name)]
        if alignments[name].offset > 0.0 or resolutions[name] > 0.0:
            found.append(("offset", name))
    if any(segment.late.any() for segment in segments):
        found.append(("stamps", ""))
    return Logging((*found, ("clock", "")), ranges, resolutions, positions, alignments)


def _rates(segment: Segment, values: Array) -> list[Array]:
    """[SI/s] Of each signal; rows that jitter are as far apart as they are."""
    apart = segment.time if segment.late.any() else segment.spacing
    return [np.gradient(column, apart) for column in values]


def _filtered(column: Array, time: float, spacing: float) -> Array:
    """First-order low pass of a column, as a logger computes it from row to row."""
    if time <= 0.0:
        return column
    share = -np.expm1(-spacing / time)
    done: Array = lfilter([share], [1.0, share - 1.0], column - column[0]) + column[0]
    return done
