"""Small errors of clocks, scales and zeros that every logger has, common to all recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.numbers import (
    CLOCK_PRIOR,
    OFFSET_PRIOR,
    POSITION_SCALE_PRIOR,
    SCALE_PRIOR,
    SHIFT_SHARE,
)
from gmfbo.diagnosis.comparison.segments import Segment
from gmfbo.diagnosis.scoring.nuisances import Alignment

Array = NDArray[np.float64]


def nuisance_names(
    segments: Sequence[Segment],
    positions: frozenset[str],
    alignments: Mapping[str, Alignment],
) -> list[tuple[str, str]]:
    """Each nuisance: its kind and its signal.

    Parameters
    ----------
    segments : sequence of Segment
        Stretches that are compared.
    positions : frozenset of str
        Signals in the position's unit: their zero is the twin's own.
    alignments : mapping of str to Alignment
        Priors by signal, as the twin file widens them.
    """
    signals = list(dict.fromkeys(name for s in segments for name in s.names))
    found = []
    for name in signals:
        found += [("shift", name), ("scale", name)]
        if name not in positions or alignments[name].offset > OFFSET_PRIOR:
            found.append(("offset", name))
    return [*found, ("clock", "")]


def nuisance_columns(
    names: Sequence[tuple[str, str]],
    segments: Sequence[Segment],
    simulated: Sequence[Array],
    ranges: Mapping[str, float],
    positions: frozenset[str],
    alignments: Mapping[str, Alignment],
) -> list[Array]:
    """Change of the signals per standard deviation of each nuisance, shape (n_nuisances, m, n).

    Parameters
    ----------
    names : sequence of (str, str)
        As `nuisance_names` gives them.
    segments : sequence of Segment
        Stretches that are compared.
    simulated : sequence of ndarray, shape (m, n)
        [SI] By segment.
    ranges : mapping of str to float
        [SI] Of each recorded signal.
    positions, alignments
        As in `nuisance_names`.
    """
    made = []
    for segment, values in zip(segments, simulated, strict=True):
        rates = np.gradient(values, segment.spacing, axis=1)
        columns = np.zeros((len(names), *values.shape))
        for i, (kind, name) in enumerate(names):
            if kind == "clock":
                columns[i] = CLOCK_PRIOR * (segment.time - segment.times[0][0]) * rates
                continue
            if name not in segment.names:
                continue
            row, prior = segment.names.index(name), alignments[name]
            if kind == "shift":
                columns[i, row] = (prior.shift or SHIFT_SHARE * segment.spacing) * rates[row]
            elif kind == "scale":
                usual = POSITION_SCALE_PRIOR if name in positions else SCALE_PRIOR
                columns[i, row] = max(usual, prior.scale) * values[row]
            else:
                columns[i, row] = max(OFFSET_PRIOR, prior.offset) * ranges[name]
        made.append(columns)
    return made
