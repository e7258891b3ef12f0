"""What all hypotheses have in common: recordings, simulators, stretches and nuisances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.noise.slow_rounding import between_counts, slow_rounding
from gmfbo.diagnosis.comparison.nuisance_columns import Logging
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, through
from gmfbo.diagnosis.comparison.segments import Segment
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.runs.simulations import Simulations

Array = NDArray[np.float64]

_RUN_AWAY = 1e6  # times a signal's range


@dataclass(frozen=True)
class EncoderCounts:
    """Counts in which a twin reads its position, or another angle.

    Attributes
    ----------
    values : mapping of str to float
        [FMU's unit] FMU parameters that set them, at values with which there are none to speak of.
    count : float
        [SI unit] Quantum of the position; 0 where only something else is counted.
    """

    values: Mapping[str, float]
    count: float


@dataclass(frozen=True, eq=False)
class Problem:
    """Recordings against an augmented twin.

    Attributes
    ----------
    simulations : Simulations
        Simulators of the twin.
    segments : tuple of Segment
        Stretches that are compared.
    recorded : tuple of ndarray, shape (m, n)
        [SI] By segment.
    logging : Logging
        Errors that the logger may have made.
    stretch_rows : int
        Rows of a stretch, the unit that is weighted in the comparison.
    followed : PortKernels, or None
        Where a loop holds an open-loop twin on its recorded position: what an error of that
        position, at the sensor port, leaves in the residual of each signal.
    held_inertia : (str, float), or None
        Parameter and value for which that loop was designed.
    is_counted : bool
        Whether simulations read the position in counts, which small changes shuffle.
    encoder : EncoderCounts or None
        Those of the twin, without which it is simulated.
    """

    simulations: Simulations
    segments: tuple[Segment, ...]
    recorded: tuple[Array, ...]
    logging: Logging
    stretch_rows: int
    followed: PortKernels | None = None
    held_inertia: tuple[str, float] | None = None
    is_counted: bool = False
    encoder: EncoderCounts | None = None

    @property
    def ranges(self) -> Mapping[str, float]:
        """[SI] Of each recorded signal, over all segments."""
        return self.logging.ranges

    @property
    def positions(self) -> frozenset[str]:
        """Signals in the position's unit."""
        return self.logging.positions

    @property
    def nuisances(self) -> tuple[tuple[str, str], ...]:
        """Kind and signal of each error of the logger."""
        return self.logging.names

    def point(
        self, hypothesis: Hypothesis, x: Array, own: Sequence[Mapping[str, float]] = ()
    ) -> Point:
        """Where the twin is run for these values of the free quantities, shape (p,).

        Parameters
        ----------
        hypothesis : Hypothesis
            Whose quantities they are.
        x : ndarray, shape (p,)
            Values.
        own : sequence of mapping of str to float
            By recording, values of some of them in it.
        """
        point = self._held(hypothesis.point(x))
        if not own:
            return point
        names = hypothesis.names
        each = [
            np.array([v.get(n, common) for n, common in zip(names, x, strict=True)]) for v in own
        ]
        return replace(point, own=[self._held(hypothesis.point(x_own)) for x_own in each])

    def without_counts(self, point: Point) -> Point:
        """The same without the counts of encoders, where they are known."""
        if self.encoder is None:
            return point
        return replace(point, parameters={**point.parameters, **self.encoder.values})

    def as_it_came(self, nominal: list[Simulated]) -> list[Simulated]:
        """Recordings simulated by the twin as it came, without the counts of its encoders.

        Parameters
        ----------
        nominal : list of Simulated
            The same with them.
        """
        if self.encoder is None:
            return nominal
        return self.simulations.run([self.without_counts(Point())])[0]

    def _held(self, point: Point) -> Point:
        """The same without the counts of an encoder, or with the loop that holds an open-loop twin.

        A loop that holds an open-loop twin keeps its poles: else the least inertia would be held
        best, and fit best.
        """
        if self.encoder is not None:
            return self.without_counts(point)
        tracking = self.simulations.tracking
        if tracking is None or self.held_inertia is None:
            return point
        name, designed = self.held_inertia
        if name not in point.parameters:
            return point
        share = point.parameters[name] / designed
        loop = {key: value * share for key, value in tracking.settings.items()}
        return replace(point, physics={**point.physics, **loop})

    def values(self, runs: Sequence[Simulated]) -> list[Array]:
        """Signals of simulated recordings on the segments' rows, shape (m, n)."""
        return [segment.read(runs[segment.record].signals) for segment in self.segments]

    def simulated(self, point: Point) -> list[Array] | None:
        """Signals of the recordings at a point; None where the twin does not get through them."""
        runs = self.simulations.run([point])[0]
        if not all(run.finite for run in runs):
            return None
        values = self.values(runs)
        return None if self.has_run_away(values) else values

    def has_run_away(self, values: Sequence[Array]) -> bool:
        """Whether a signal left all that was recorded, so that its squares may overflow."""
        return any(
            np.max(np.abs(own - was)) > _RUN_AWAY * self.ranges[name] > 0.0
            for segment, columns, recorded in zip(self.segments, values, self.recorded, strict=True)
            for name, own, was in zip(segment.names, columns, recorded, strict=True)
        )

    def square_by_range(self, change: Sequence[Array]) -> float:
        """Square of a change of the signals, by the range of each, over all segments."""
        extents = [[self.ranges[name] or 1.0 for name in s.names] for s in self.segments]
        shares = zip(change, extents, strict=True)
        return float(sum(np.sum((c / np.array(e)[:, None]) ** 2) for c, e in shares))

    def residual(self, values: Sequence[Array], nuisances: Array) -> list[Array]:
        """[SI] Recorded less simulated, as the logger stores it, by segment."""
        stored = self.as_stored(values, nuisances)
        return [y - own for y, own in zip(self.recorded, stored, strict=True)]

    def as_stored(self, values: Sequence[Array], nuisances: Array) -> list[Array]:
        """[SI] Simulated signals as the logger stores them, by segment."""
        stored = []
        for segment, own in zip(self.segments, values, strict=True):
            change = self.logging.seen(segment, own, nuisances) - own
            if self.followed is not None:
                change = self._left(segment, change[None])[0]
            stored.append(own + change)
        return stored

    def nuisance_columns(self, values: Sequence[Array], nuisances: Array) -> list[Array]:
        """Change of the signals per standard deviation of each nuisance, shape (q, m, n)."""
        made = [
            self.logging.slopes(segment, own, nuisances)
            for segment, own in zip(self.segments, values, strict=True)
        ]
        if self.followed is None:
            return made
        return [self._left(s, d) for s, d in zip(self.segments, made, strict=True)]

    def slow_rounding(self, dither: float) -> list[Array]:
        """What rounding of slow motion leaves where the twin follows a position, shape (k, m, n).

        Parameters
        ----------
        dither : float
            [standard deviations of rounding] White noise that was rounded with the position.
        """
        found = []
        for segment, own in zip(self.segments, self.recorded, strict=True):
            columns = np.zeros((0, *own.shape))
            for i, name in enumerate(segment.names):
                count = self.logging.resolutions[name]
                if self.followed is not None and name in self.positions and count > 0.0:
                    errors = slow_rounding(
                        between_counts(own[i]), count, dither * count / np.sqrt(12.0)
                    )
                    columns = np.zeros((len(errors), *own.shape))
                    columns[:, i] = errors
                    columns = self._left(segment, columns)
            found.append(columns)
        return found

    def _left(self, segment: Segment, columns: Array) -> Array:
        """What errors of the recorded position leave, since the twin follows them in part."""
        assert self.followed is not None
        out = columns.copy()
        place = next((i for i, n in enumerate(segment.names) if n in self.positions), None)
        if place is None:
            return out
        out[:, place] = 0.0
        paths = self.followed.of(segment.record).kernels
        for i, name in enumerate(segment.names):
            out[:, i] += through(columns[:, place], paths["sensor"][name])
        return out

    def rates(self, values: Sequence[Array]) -> list[Array]:
        """[SI/s] Rates of the positions, 0 for other signals, shape (m, n)."""
        made = []
        for segment, columns in zip(self.segments, values, strict=True):
            rate = np.gradient(columns, segment.spacing, axis=1)
            shown = np.array([name in self.positions for name in segment.names])
            made.append(rate * shown[:, None])
        return made

    def stretches(self) -> list[list[slice]]:
        """Rows of the stretches of each segment; all of a segment but what is left at its end."""
        found = []
        for segment in self.segments:
            n = segment.time.size
            count = max(1, round(n / self.stretch_rows))
            edges = np.linspace(0, n, count + 1).astype(int)
            found.append([slice(a, b) for a, b in pairwise(edges)])
        return found

    def by_stretch(self, values: Sequence[Array]) -> list[Array]:
        """Sums over the signals and rows of each stretch, by segment.

        Parameters
        ----------
        values : sequence of ndarray, shape (m, n)
            By segment.
        """
        return [
            np.array([np.sum(own[:, rows]) for rows in stretches])
            for own, stretches in zip(values, self.stretches(), strict=True)
        ]
