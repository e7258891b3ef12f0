"""Segments: stretches of recordings whose signals lie on one grid and are compared as one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.scored_record import LEAST_ROWS, Record
from gmfbo.diagnosis.scoring.whitening import Window

Array = NDArray[np.float64]

_EVEN = 1e-3  # of a row: nearer to an even clock is how times are written


@dataclass(frozen=True, eq=False)
class Segment:
    """A stretch of a recording without a gap.

    Attributes
    ----------
    record : int
        Index of the recording.
    names : tuple of str
        Its m signals.
    time : ndarray, shape (n,)
        [s] Of the rows, those of the slowest signal.
    times : tuple of ndarray
        [s] Of each signal over the whole recording.
    stamps : ndarray, shape (n,), or None
        [s] Of the rows, as the logger wrote them; None where that is not known.
    """

    record: int
    names: tuple[str, ...]
    time: Array
    times: tuple[Array, ...]
    stamps: Array | None = None

    @property
    def spacing(self) -> float:
        """[s] Between rows."""
        return float(self.time[-1] - self.time[0]) / (self.time.size - 1)

    @cached_property
    def late(self) -> Array:
        """[s] By which the stamp of each row is later than on an even clock, shape (n,)."""
        rows, stamps = np.arange(self.time.size, dtype=np.float64), self.stamps
        since = self.time - self.time[0] if stamps is None else stamps - stamps[0]
        off: Array = since - np.polyval(np.polyfit(rows, since, 1), rows)
        return off if np.abs(off).max() > _EVEN * self.spacing else np.zeros_like(off)

    def read(self, columns: Sequence[Array]) -> Array:
        """Signals on the segment's rows, shape (m, n).

        Parameters
        ----------
        columns : sequence of ndarray
            One a signal, over the whole recording.
        """
        return np.stack([_on(self.time, t, c) for t, c in zip(self.times, columns, strict=True)])


def segments_of(
    records: Sequence[Record], windows: Sequence[Window], settled: float
) -> tuple[Segment, ...]:
    """Join the windows of each recording that follow one another.

    Parameters
    ----------
    records : sequence of Record
        Recordings that are compared.
    windows : sequence of Window
        Stretches that can be compared, in order.
    settled : float
        [s] After which a motion is over, in a long rest that is not compared.
    """
    found: list[Segment] = []
    joined: list[tuple[int, list[slice]]] = []
    for window in windows:
        last = joined[-1] if joined else None
        if last and last[0] == window.record and _follows(last[1], window.rows):
            last[1][:] = [slice(a.start, b.stop) for a, b in zip(last[1], window.rows, strict=True)]
        else:
            joined.append((window.record, list(window.rows)))
    for k, rows in joined:
        signals = records[k].signals
        slowest = int(np.argmax([s.spacing for s in signals]))
        time = signals[slowest].time[rows[slowest]]
        names = tuple(s.name for s in signals)
        stamps = signals[slowest].stamps
        stamps = None if stamps is None else stamps[rows[slowest]]
        whole = Segment(k, names, time, tuple(s.time for s in signals), stamps)
        found += _without_rests(whole, records[k].rests, settled)
    return tuple(found)


def _without_rests(
    whole: Segment, rests: Sequence[tuple[float, float]], settled: float
) -> list[Segment]:
    """What is left of a segment without long rests, which keep what settles after a motion.

    Where friction holds an axis, noise goes other ways than round the loop, and lets it creep by
    what contacts of micrometres allow. Pieces too short for the filters are left out too, unless
    nothing else is left.
    """
    time, inside = whole.time, np.ones(whole.time.size, dtype=bool)
    for start, end in rests:
        # What settles at the start comes of where the twin began.
        kept = start + settled if start > time[0] + settled else time[0]
        inside &= (time < kept) | (time > end)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(int), [0]])))
    pieces = [slice(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    long = [piece for piece in pieces if piece.stop - piece.start >= LEAST_ROWS]
    stamps = whole.stamps
    cut = [None if stamps is None else stamps[piece] for piece in long]
    parts = [replace(whole, time=time[p], stamps=s) for p, s in zip(long, cut, strict=True)]
    return parts or [whole]


def _follows(before: Sequence[slice], after: Sequence[slice]) -> bool:
    return all(a.stop == b.start for a, b in zip(before, after, strict=True))


def _on(rows: Array, time: Array, column: Array) -> Array:
    first = int(np.searchsorted(time, rows[0] - 1e-9))
    if time.size >= first + rows.size and np.allclose(
        time[first : first + rows.size], rows, rtol=0.0, atol=1e-6 * (rows[1] - rows[0])
    ):
        return column[first : first + rows.size]
    return np.interp(rows, time, column)
