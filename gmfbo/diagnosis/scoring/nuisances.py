"""Nuisances: small errors of clocks, scales and zeros that every rig has.

Each nuisance is a direction in signal space, one standard deviation of its prior long. Residuals
are freed of them as far as the priors allow (Whitener.without), so no effect gains by them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.scored_record import Record, ScoredSignal
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.runs.start_changes import start_changes
from gmfbo.sources.twin_file.entries import OutputEntry

Direction = tuple[NDArray[np.float64], ...]
"""One array a signal."""

SCALE, POSITION_SCALE = 0.02, 3e-4
"""Priors of column scales: current and torque sensors are within 1-3 %, encoders exact."""

CLOCK_SKEW = 2e-4
"""Quartz clocks of two devices differ by up to 100 ppm each."""

SHIFT_SHARE = 0.1
"""Of a sample: a column may be latched at any time within its period."""

ACTUATOR_LAG_S, ACTUATOR_GAIN = 2.5e-4, 0.02
"""Current loops differ from their twins by 0.1-0.3 ms, torque constants by 2 %."""

OFFSET = 5e-4
"""Prior of a column's zero, as a share of its range."""

_FREE = 10.0  # times the range: as good as no prior


@dataclass(frozen=True)
class Alignment:
    """Priors of one signal's nuisances.

    Attributes
    ----------
    scale : float
        Standard deviation, as a share.
    offset : float or None
        Standard deviation as a share of the range.
    shift : float or None
        [s] Standard deviation; None for a share of its sampling.
    """

    scale: float
    offset: float
    shift: float | None = None


def alignment_of(entry: OutputEntry, *, is_position: bool, is_command: bool = False) -> Alignment:
    """Priors that the twin file states, or else those of common sensors.

    A controller's command is a number in its memory, and no sensor's zero is in it: with one, an
    integral part that holds a constant force would be taken for a column that is off.
    """
    scale = POSITION_SCALE if is_position else SCALE
    offset = 0.0 if is_position or is_command else OFFSET
    shift = None
    if entry.uncertain_scale is not None:
        scale = max(scale, entry.uncertain_scale)
    if entry.offset == "fit":
        offset = _FREE
    if entry.shift_range is not None:
        shift = 0.5 * (entry.shift_range[1] - entry.shift_range[0])
    return Alignment(scale, offset, shift)


def record_directions(
    record: Record, simulated: Simulated, alignments: Mapping[str, Alignment]
) -> list[Direction]:
    """Directions of the columns of one recording: scale, offset, shift, clock.

    Parameters
    ----------
    record : Record
        Recording that is scored.
    simulated : Simulated
        The recording simulated, without noise.
    alignments : mapping of str to Alignment
        Priors by signal.
    """
    directions = []
    skew: list[NDArray[np.float64]] = []
    for i, (signal, values) in enumerate(zip(record.signals, simulated.signals, strict=True)):
        rate = _rate(signal, values)
        skew.append(CLOCK_SKEW * (signal.time - record.start) * rate)
        prior = alignments[signal.name]
        shift = prior.shift or SHIFT_SHARE * signal.spacing
        directions.append(_only(record, i, shift * rate))
        directions.append(_only(record, i, prior.scale * values))
        if prior.offset:
            extent = float(np.ptp(signal.values))
            directions.append(_only(record, i, np.full(values.size, prior.offset * extent)))
    directions.append(tuple(skew))
    return directions


def actuator_directions(
    simulations: Simulations, point: Point, base: list[Simulated], record: int, torque: float
) -> list[Direction]:
    """Directions of a slightly wrong actuator: its lag and gain, simulated in the loop.

    Parameters
    ----------
    simulations : Simulations
        Simulators of the twin.
    point : Point
        Values at which the twin runs.
    base : list of Simulated
        All recordings simulated there.
    record : int
        Index of the recording.
    torque : float
        Torque at the port for a unit of command, where there is no command port.
    """
    states = base[record].response.states
    ports = base[record].response.ports
    told = states.get("command", states.get("current"))
    if told is None or not {"command", "torque"} & set(ports):
        return []
    port, gain = ("command", 1.0) if "command" in ports else ("torque", torque)
    command = _smooth(told)
    grid = simulations.records[record].plan.grid

    def with_more(column: NDArray[np.float64]) -> Simulated:
        return simulations.run_one(point, record, excitation={port: gain * column})

    if simulations.tracking is not None and "command" in ports:
        # A recorded command also has a fast part, and it lags too.
        physics = {**point.physics, "actuator_lag.time": ACTUATOR_LAG_S}
        lagging = simulations.run_one(replace(point, physics=physics), record)
    else:
        lagging = with_more(-ACTUATOR_LAG_S * np.gradient(command, grid))
    directions = []
    for run in (lagging, with_more(ACTUATOR_GAIN * command)):
        if run.finite:
            directions.append(
                tuple(a - b for a, b in zip(run.signals, base[record].signals, strict=True))
            )
    return directions


def nuisance_directions(
    simulations: Simulations,
    point: Point,
    base: list[Simulated],
    alignments: Mapping[str, Alignment],
    torque_per_command: float,
) -> list[list[Direction]]:
    """Nuisances of each recording, about a simulated point.

    Parameters
    ----------
    simulations : Simulations
        Simulators of the twin.
    point : Point
        Values at which the twin runs.
    base : list of Simulated
        The recordings simulated there.
    alignments : mapping of str to Alignment
        Priors of the signals.
    torque_per_command : float
        Torque at the port for a unit of command.
    """

    starts = start_changes(simulations, point, base)

    def one(k: int) -> list[Direction]:
        record = simulations.records[k]
        own = record_directions(record, base[k], alignments)
        if simulations.tracking is not None:
            own = [_followed(simulations, point, base[k], k, error) for error in own]
        own += [start[k] for start in starts]
        return own + actuator_directions(simulations, point, base, k, torque_per_command)

    return list(simulations.map(one, range(len(base))))


def _followed(
    simulations: Simulations, point: Point, base: Simulated, record: int, direction: Direction
) -> Direction:
    """Part of a recorded position's error that stays in the residual when a loop follows it."""
    encoder, signals = simulations.encoder, simulations.records[record].signals
    place = next((i for i, s in enumerate(signals) if encoder and s.name == encoder.signal), None)
    if encoder is None or place is None:
        return direction
    grid = simulations.records[record].plan.grid
    error = np.interp(grid, signals[place].time, direction[place]) / encoder.to_si
    run = simulations.run_one(point, record, measured_noise=error)
    if not run.finite:
        return direction
    moved = zip(direction, run.signals, base.signals, strict=True)
    return tuple(one - (after - before) for one, after, before in moved)


def _rate(signal: ScoredSignal, values: NDArray[np.float64]) -> NDArray[np.float64]:
    rate: NDArray[np.float64] = np.gradient(values, signal.spacing)
    return rate


def _only(record: Record, place: int, column: NDArray[np.float64]) -> Direction:
    return tuple(
        column if i == place else np.zeros(signal.values.size)
        for i, signal in enumerate(record.signals)
    )


def _smooth(column: NDArray[np.float64]) -> NDArray[np.float64]:
    kernel = np.ones(5) / 5.0
    padded = np.pad(column, 2, mode="edge")
    smooth: NDArray[np.float64] = np.convolve(padded, kernel, mode="valid")
    return smooth
