"""Windows: stretches of the recordings that are scored separately."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.scored_record import LEAST_ROWS, Record, ScoredSignal
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.scoring.noise_levels import SECOND_DIFFERENCE, rounding_of
from gmfbo.diagnosis.scoring.whitening import Window, make_window
from gmfbo.errors import RecordingError

_WINDOW_S = 1.2
_MOST_WINDOWS = 4
_LEAST_WINDOWS = 4  # in all, where the loop is fast enough for it
_LOOP_TIMES = 5.0
SETTLING = 10.0
"""Loop times after which e^-10 of an initial error remains."""

_FIRST_ROWS = 5
_ROWS_OF_SLOPE = 8  # a third of a usual second difference is then one deviation of the slope
_ELSEWHERE = 0.02  # of a signal's range: a larger difference at the start is another state


def windows_of(
    records: Sequence[Record],
    loop_time: float,
    nominal: Sequence[Simulated] = (),
    positions: Collection[str] = (),
) -> tuple[Window, ...]:
    """Cut each recording into stretches of about a second that can be left out one by one.

    Parameters
    ----------
    records : sequence of Record
        Recordings that are scored.
    loop_time : float
        [s] Slowest time constant of the closed loop; a stretch is at least five long.
    nominal : sequence of Simulated, optional
        The twin as it is; a recording that starts in another state is scored after settling.
    positions : collection of str
        Signals that decide whether a recording starts elsewhere.

    Raises
    ------
    RecordingError
        Nothing is left to score.
    """
    windows: list[Window] = []
    total = sum(record.end - record.start for record in records)
    # Few or short recordings are cut finer, so that a window can be left out of a fit.
    width = max(min(_WINDOW_S, total / _LEAST_WINDOWS), _LOOP_TIMES * loop_time)
    for k, record in enumerate(records):
        elsewhere = bool(nominal) and starts_elsewhere(record, nominal[k], positions, loop_time)
        found = [
            window
            for stretch in record.stretches(SETTLING * loop_time, starts_elsewhere=elsewhere)
            for window in _windows_within(k, record, stretch, width)
        ]
        windows += found
    if not windows:
        raise RecordingError(
            f"expected at least {LEAST_ROWS} rows in a row after the start has been forgotten, "
            f"{SETTLING * loop_time:.2g} s; got none; record longer, or without gaps, or "
            'state the start in [initial]: a recorded signal, a number, or "fit"'
        )
    return tuple(windows)


def _windows_within(
    k: int, record: Record, stretch: tuple[float, float], width: float
) -> list[Window]:
    start, end = stretch
    # Rounded up by a row: a recording of four widths is cut in four.
    parts = int(np.clip((end - start) * (1.0 + 1e-6) // width, 1, _MOST_WINDOWS))
    ranges = []
    for signal in record.signals:
        slack = 1e-6 * signal.spacing
        first, last = np.searchsorted(signal.time, [start - slack, end + slack])
        ranges.append((int(first), int(last)))
    if max(last - first for first, last in ranges) < LEAST_ROWS:
        return []
    windows = []
    for part in range(parts):
        rows = [
            slice(a + part * (b - a) // parts, a + (part + 1) * (b - a) // parts) for a, b in ranges
        ]
        windows.append(make_window(k, [s.spacing for s in record.signals], rows))
    return windows


def starts_elsewhere(
    record: Record, nominal: Simulated, positions: Collection[str], loop_time: float
) -> bool:
    """Whether a recording starts at another position or speed than its twin.

    Within the first few rows neither parameters nor physics move anything that was at rest. Told
    by positions, since a command differs by any load; a wrong speed goes on for `loop_time`.
    The speed is the first slope of a parabola, since an axis that is let go accelerates at once,
    and not as its twin does.

    Parameters
    ----------
    record : Record
        As recorded.
    nominal : Simulated
        The same, as the twin runs.
    positions : collection of str
        Signals that decide.
    loop_time : float
        [s] Time constant of the closed loop.
    """
    for signal, values in zip(record.signals, nominal.signals, strict=True):
        if signal.name not in positions:
            continue
        noise, bound = _noise_and_bound(signal)
        moved = abs(_first_slope(signal.values, values)) * loop_time / signal.spacing
        if starts_apart(signal, values) or moved > bound + noise * loop_time / signal.spacing:
            return True
    return False


def starts_apart(signal: ScoredSignal, values: NDArray[np.float64]) -> bool:
    """Whether a recorded signal begins at another value than these, beyond noise.

    Parameters
    ----------
    signal : ScoredSignal
        As recorded.
    values : ndarray, shape (n,)
        [SI] The same signal as simulated, or in another recording.
    """
    _, bound = _noise_and_bound(signal)
    return abs(first_difference(signal, values)) > bound


def first_difference(signal: ScoredSignal, values: NDArray[np.float64]) -> float:
    """[SI] By which a recorded signal begins above these values.

    Parameters
    ----------
    signal, values
        As of `starts_apart`.
    """
    return float(np.median(signal.values[:_FIRST_ROWS] - values[:_FIRST_ROWS]))


def _noise_and_bound(signal: ScoredSignal) -> tuple[float, float]:
    """Size of a signal's noise, and the difference at its start that is another state."""
    rounding = SECOND_DIFFERENCE * rounding_of(signal)
    noise = max(float(np.median(np.abs(np.diff(signal.values, 2)))), rounding)
    return noise, max(_ELSEWHERE * float(np.ptp(signal.values)), 3.0 * noise)


def _first_slope(recorded: NDArray[np.float64], simulated: NDArray[np.float64]) -> float:
    """Difference of both slopes at the first row, per row."""
    rows = slice(0, _ROWS_OF_SLOPE)
    apart = recorded[rows] - simulated[rows]
    return float(np.polynomial.Polynomial.fit(np.arange(apart.size), apart, 2).deriv()(0.0))
