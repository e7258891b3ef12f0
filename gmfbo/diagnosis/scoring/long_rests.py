"""Long rests, which are left out of the comparison but for their beginnings and ends.

An axis that friction holds tells little of its motion, and misleads where it is long held: noise
that its controller reads lets it creep, as far as contacts of micrometres allow (Armstrong-Helouvry
et al. 1994, section 2.1), and goes other ways through a loop that does not move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.measured_excitation import FASTEST, REST_SHARE
from gmfbo.diagnosis.runs.scored_record import LEAST_ROWS, Gap, Record, ScoredSignal
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.windows import SETTLING

Array = NDArray[np.float64]


def leave_out_long_rests(
    simulations: Simulations, simulated: Sequence[Simulated], position: str | None, loop_time: float
) -> list[str]:
    """Leave out what twin and recordings rest for, but for the first and last loop times.

    Parameters
    ----------
    simulations : Simulations
        Its records get a gap in each long rest.
    simulated : sequence of Simulated
        The recordings, as the twin runs.
    position : str or None
        Signal whose motion counts; without one nothing is left out.
    loop_time : float
        [s] Time constant of the closed loop.

    Returns
    -------
    list of str
        A note, where something was left out.
    """
    if simulations.tracking is not None:
        return []  # noise goes round no loop
    found, left_out = [], 0.0
    pairs = list(zip(simulations.records, simulated, strict=True))
    moving = [_moving(record, run, position, loop_time) for record, run in pairs]
    speeds = [motion.simulated for motion in moving if motion is not None]
    slowest = REST_SHARE * float(np.quantile(np.concatenate(speeds), FASTEST)) if speeds else 0.0
    for (record, _), motion in zip(pairs, moving, strict=True):
        gaps = [] if motion is None else motion.rests(slowest, loop_time)
        left_out += sum(gap.end - gap.start for gap in gaps)
        found.append(replace(record, gaps=(*record.gaps, *gaps)))
    simulations.records = tuple(found)
    if left_out == 0.0:
        return []
    return [
        f"{left_out:.3g} s at rest were not compared: an axis that friction holds tells little "
        "there, and creeps as noise shakes it"
    ]


class _Motion:
    """Speeds of a position, as recorded and as simulated.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s]
    recorded, simulated : ndarray, shape (n,)
        [SI/s] Amounts, of the mean over a loop time.
    """

    def __init__(self, signal: ScoredSignal, values: Array, loop_time: float) -> None:
        rows = max(1, round(loop_time / signal.spacing))
        self.time = signal.time
        self.recorded = _speed(signal.values, rows, signal.spacing)
        self.simulated = _speed(values, rows, signal.spacing)

    def rests(self, slowest: float, loop_time: float) -> list[Gap]:
        """Long rests, without their first and last loop times; none where nothing moves."""
        spacing = float(self.time[1] - self.time[0])
        kept = max(LEAST_ROWS, round(SETTLING * loop_time / spacing))
        # A twin has no noise, so that its slowest motion is seen.
        at_rest = (self.recorded <= slowest) & (self.simulated <= REST_SHARE * slowest)
        if at_rest.all():
            return []
        edges = np.flatnonzero(np.diff(np.concatenate([[0], at_rest.astype(int), [0]])))
        found = []
        for first, behind in zip(edges[::2], edges[1::2], strict=True):
            start = first + kept if first > 0 else first
            end = behind - kept if behind < at_rest.size else behind
            if end - start > 2 * kept:  # most of it
                found.append(Gap(float(self.time[start]), float(self.time[end - 1]), False))
        return found


def _moving(
    record: Record, simulated: Simulated, position: str | None, loop_time: float
) -> _Motion | None:
    for signal, values in zip(record.signals, simulated.signals, strict=True):
        if signal.name == position:
            return _Motion(signal, values, loop_time)
    return None


def _speed(values: Array, rows: int, spacing: float) -> Array:
    """Amount of the difference of means before and after each row, [SI/s]."""
    padded = np.concatenate([np.full(rows, values[0]), values, np.full(rows, values[-1])])
    sums = np.concatenate([[0.0], np.cumsum(padded)])
    means = (sums[rows:] - sums[:-rows]) / rows
    n = values.size
    speed: Array = np.abs(means[rows + 1 : rows + 1 + n] - means[:n]) / ((rows + 1) * spacing)
    return speed
