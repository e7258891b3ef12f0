"""Derivatives of what is white in a closed loop: the information of a recording, none left out.

The controller makes its command of what it reads, and the twin knows how. Of position y and command
u as they were logged, and C the controller, P the plant,

    e_1 = y - P(C(r, y)) and e_2 = u - C(r, y)

are the noise of the encoder and that of the command's column, white and independent, whatever the
law does (prediction errors, Ljung 1999, "System Identification", section 13.4). So the likelihood
of a recording is exact in them, where the spectrum of a stretch of y and u would leave out how its
frequencies hang together.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.blind.draw.fit_of_the_true_law import TrueLaw
from tests.blind.draw.noise_of_a_case import driven, encoder_noise, logged_command
from tests.blind.oracle import Experiment
from tests.blind.truth import PREROLL, SAMPLE, Vector, simulate

_SMALL = 1e-3
"""Of a signal: a change for which a drive in its limits stays where it is."""


_UNMOVED = 1e12
"""[inertia] Of an axis that nothing moves."""

CONTROLLERS = frozenset({"filter_time", "u_limit"})
"""Plant parameters that are the controller's."""


class PredictionErrors:
    """Derivatives of e_1 and e_2, each over its noise, about a clean run of the truth.

    Parameters
    ----------
    law : TrueLaw
        Of a closed loop, whose noise is of the encoder and of the command's column alone.
    """

    def __init__(self, law: TrueLaw) -> None:
        self.law = law
        self._runs = [
            simulate({**law.case.plant, **one.gains}, one.reference) for one in law.case.experiments
        ]
        self._signals = []
        for run in self._runs:
            signals = np.column_stack([run.reading, run.new])
            signals[0, 0] = run.position[0]  # where a run under the command begins
            self._signals.append(signals)

    def by_values(self) -> Vector:
        """By what is free, shape (n, n_free)."""
        free, parts = self.law.free, []
        for one, signals in zip(self.law.case.experiments, self._signals, strict=True):
            e_1, e_2 = [], []
            for k, (names, step) in enumerate(zip(free.groups, free.steps, strict=True)):
                x = np.zeros(len(free.groups))
                x[k] = step
                ends = [free.at(way * x) for way in (1.0, -1.0)]
                if CONTROLLERS & set(names):
                    made = [
                        command_of({**end, **one.gains}, one.reference, signals[:, 0])
                        for end in ends
                    ]
                    e_2.append((made[0] - made[1]) / (2.0 * step))
                    e_1.append(self._pushed(signals, e_2[-1]))
                else:
                    moved = [driven(end, signals) for end in ends]
                    e_1.append((moved[0] - moved[1]) / (2.0 * step))
                    e_2.append(0.0 * e_1[-1])
            parts.append(self._stacked(e_1, e_2))
        return np.vstack(parts)

    def by_starts(self) -> Vector:
        """By place and speed at each start, and by what an integral part holds there."""
        has_integral = self.law.case.plant.get("ki", 0.0) != 0.0
        blocks = []
        for signals, waves in zip(
            self._signals, self.law.starts([len(s) for s in self._signals]), strict=True
        ):
            ones = np.ones(len(signals))
            e_1, e_2 = [*waves.T], [0.0 * ones, 0.0 * ones]
            if has_integral:
                e_1.append(-self._pushed(signals, ones))
                e_2.append(-ones)
            blocks.append(self._stacked(e_1, e_2))
        return _diagonal(blocks)

    def by_columns(self) -> Vector:
        """By offset, scale and shift of both logged columns, the same in all recordings."""
        parts = []
        for one, signals, run in zip(
            self.law.case.experiments, self._signals, self._runs, strict=True
        ):
            e_1, e_2 = [], []
            for wrong in _nuisances(run.reading):
                made = self._controlled(one, wrong)
                e_1.append(wrong - self._pushed(signals, made))
                e_2.append(-made)
            for wrong in _nuisances(run.new):
                e_1.append(0.0 * wrong)
                e_2.append(wrong)
            parts.append(self._stacked(e_1, e_2))
        return np.vstack(parts)

    def _controlled(self, one: Experiment, read: Vector) -> Vector:
        """What the controller makes of a small change of what it reads."""
        alone = {**self.law.case.values, **one.gains}
        small = _SMALL * alone["u_limit"] / max(float(np.max(np.abs(read))), 1e-300)
        small /= max(alone.get("kp", 0.0) * alone.get("kv", 1.0) or 1.0, 1.0)
        return command_of(alone, np.zeros(len(read)), small * read) / small

    def _pushed(self, signals: Vector, command: Vector) -> Vector:
        """Change of the position by a small change of the command."""
        most = max(float(np.max(np.abs(command))), 1e-300)
        small = _SMALL * float(np.max(np.abs(signals[:, 1]))) / most
        change = small * np.column_stack([0.0 * command, command])
        ends = [driven(self.law.case.plant, signals + way * change) for way in (1.0, -1.0)]
        return np.asarray((ends[0] - ends[1]) / (2.0 * small))

    def _stacked(self, e_1: list[Vector], e_2: list[Vector]) -> Vector:
        """Derivatives of one recording over their noise, shape (2 rows, n)."""
        rows = len(self._signals[0]) if not e_1 else len(e_1[0])
        if not e_1:
            return np.zeros((2 * rows, 0))
        case = self.law.case
        white = _whitener(logged_command(case, rows))
        first = np.array(e_1).T / encoder_noise(case)
        return np.vstack([first, white(np.array(e_2).T)])


def command_of(values: dict[str, float], reference: Vector, read: Vector) -> Vector:
    """Command that a controller makes of a reading, shape (rows,); its axis is held still.

    Parameters
    ----------
    values : dict of str to float
        Of the plant; those of its controller count.
    reference, read : ndarray, shape (rows,)
        [position] What is asked for, and what is read.
    """
    still = {**values, "torque_gain": 0.0, "inertia": _UNMOVED}
    noise = np.concatenate([np.full(PREROLL, read[0]), read])
    return simulate(still, reference, noise).new


def _nuisances(column: Vector) -> list[Vector]:
    return [np.ones_like(column), column, np.gradient(column, SAMPLE)]


def _whitener(power: Vector) -> Callable[[Vector], Vector]:
    """Divides columns by the noise of this power by frequency, shape (rows // 2 + 1,)."""
    if np.ptp(power) == 0.0:
        return lambda columns: columns / np.sqrt(power[0])
    return lambda columns: np.fft.irfft(
        np.fft.rfft(columns, axis=0) / np.sqrt(power)[:, None], n=len(columns), axis=0
    )


def _diagonal(blocks: list[Vector]) -> Vector:
    """Blocks one after the other along the diagonal."""
    whole = np.zeros((sum(len(b) for b in blocks), sum(b.shape[1] for b in blocks)))
    row = column = 0
    for b in blocks:
        whole[row : row + len(b), column : column + b.shape[1]] = b
        row, column = row + len(b), column + b.shape[1]
    return whole
