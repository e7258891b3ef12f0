"""Counts of an encoder within the twin that no compared signal comes in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.starting.finer_counts import ENOUGH, FINER, times
from gmfbo.diagnosis.comparison.starting.fixed_parameters import SMALL_CHANGE, changeable
from gmfbo.diagnosis.fitting.difference_steps import SMOOTH, bent_shares
from gmfbo.diagnosis.runs.simulated import Point, Simulated

Array = NDArray[np.float64]

_TINY = 1e-4  # of a parameter's scale: a smooth answer hardly changes, counts fall otherwise
_ALIKE = 3.0  # times the change by counts that fall otherwise: another axis moves more


def hidden_counts(case: Case, fine: Mapping[str, float]) -> dict[str, float]:
    """Parameter that sets such counts, and its value that leaves none; empty where none does.

    A tiny change of any parameter lets counts fall otherwise, and the controller answers them. The
    parameter that sets them does no more than that when it is changed, slightly or a thousand
    times, and where its counts are fine a tiny change no longer shows.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    fine : mapping of str to float
        [FMU's unit] Parameters of other encoders, with which these count no more.
    """
    runs = _Runs(case, fine)
    if runs.is_smooth:
        return {}
    for one in changeable(case.twin, (), also_certain=True):
        slightly = {one.name: one.nominal * SMALL_CHANGE}
        if one.name in fine or not runs.is_the_same_axis(slightly):
            continue
        for factor in (FINER, 1.0 / FINER):
            finer = {one.name: times(case.twin, one, factor)}
            if runs.is_the_same_axis(finer) and runs.shuffle(finer) * ENOUGH < runs.shuffle({}):
                return finer
    return {}


class _Runs:
    """Runs of the longest recording, as the twin is and with tiny changes of what is uncertain."""

    def __init__(self, case: Case, fine: Mapping[str, float]) -> None:
        self._case, self._fine = case, fine
        self._record = int(np.argmax([r.plan.grid.size for r in case.simulations.records]))
        signals = case.simulations.records[self._record].signals
        self._extents = [float(np.ptp(s.values)) or 1.0 for s in signals]

    @property
    def is_smooth(self) -> bool:
        """Whether twice a tiny change does twice as much."""
        bent = bent_shares([self._columns({}, tinies) for tinies in range(3)], self._square)[0]
        return bent is None or bent <= SMOOTH

    def is_the_same_axis(self, changed: Mapping[str, float]) -> bool:
        """Whether a change does what counts do that fall otherwise, and no more."""
        return 0.0 < self._distance(changed, 0, {}, 0) < _ALIKE * self.shuffle({})

    def shuffle(self, changed: Mapping[str, float]) -> float:
        """How far a tiny change moves the signals, shares of their ranges."""
        return self._distance(changed, 0, changed, 1)

    def _distance(
        self, one: Mapping[str, float], tinies: int, other: Mapping[str, float], more: int
    ) -> float:
        a, b = self._columns(one, tinies), self._columns(other, more)
        if a is None or b is None:
            return np.inf
        return float(np.sqrt(self._square([p - q for p, q in zip(a, b, strict=True)])))

    def _columns(self, changed: Mapping[str, float], tinies: int) -> tuple[Array, ...] | None:
        tiny = {u.name: u.nominal + tinies * _TINY * u.scale for u in self._case.setting.uncertain}
        point = Point({**tiny, **self._fine, **changed})
        run: Simulated = self._case.simulations.run_one(point, self._record)
        return run.signals if run.finite else None

    def _square(self, change: Sequence[Array]) -> float:
        """Sum of the mean squares of signals, each by its range."""
        shares = zip(change, self._extents, strict=True)
        return sum(float(np.mean((own / extent) ** 2)) for own, extent in shares)
