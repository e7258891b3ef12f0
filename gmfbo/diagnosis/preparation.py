"""From twin and recordings to whitened residuals: alignment, noise, budget, nuisances."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.budget import (
    NoiseLevel,
    excess_of_repeats,
    fast_power,
    loop_covariance,
    power_beside,
    tolerance_covariance,
    white_covariance,
)
from gmfbo.diagnosis.nuisances import (
    Alignment,
    Direction,
    actuator_directions,
    alignment_of,
    record_directions,
)
from gmfbo.diagnosis.records import LEAST_ROWS, Record
from gmfbo.diagnosis.simulations import Point, Simulated, Simulations
from gmfbo.diagnosis.whitening import Spectrum, Whitener, Window, make_window
from gmfbo.errors import RecordingError
from gmfbo.sources.augmented import Response
from gmfbo.sources.binding import Binding

NOISE_RUNS = 4
"""Noise runs of each recording; smoothing over frequency does the rest."""

_WINDOW_S = 1.2
_MOST_WINDOWS = 4
_LEAST_WINDOWS = 4  # in all, where the loop is fast enough for it
_LOOP_TIMES = 5.0
_CONTAINED = 0.5  # of the sensor port's noise, which a reading holds that contains the port
_SENT = 0.1  # of a resolution, that is left where it was sent through the loop
_COARSE = 0.3  # of a position's noise, which counts make up before they are no white noise
_SETTLING = 10.0  # loop times after which e^-10 of a start is left
_FIRST_ROWS = 5
_ELSEWHERE = 0.02  # of a signal's range


@dataclass(frozen=True, eq=False)
class Rig:
    """What is known of the signals before anything is fitted.

    Attributes
    ----------
    position : str or None
        Output that is the recorded position.
    positions : frozenset of str
        Outputs in the position's unit.
    alignments : mapping of str to Alignment
        Priors of the nuisances by signal.
    position_to_si : float
        [SI unit / FMU's unit] Of the position.
    """

    position: str | None
    positions: frozenset[str]
    alignments: Mapping[str, Alignment]
    position_to_si: float


def describe_rig(binding: Binding, records: Sequence[Record]) -> Rig:
    """Tell which signals are positions, and what their columns may be off by.

    Parameters
    ----------
    binding : Binding
        The twin.
    records : sequence of Record
        Recordings; a signal that none holds does not count.
    """
    outputs, states = binding.file.outputs, binding.file.states
    present = {s.name for record in records for s in record.signals}
    unit = {
        name: binding.variables[entry.variable].variable.si_unit for name, entry in outputs.items()
    }
    position = _position_signal(binding, present)
    if position is not None:
        wanted = unit[position]
    elif "position" in states:
        wanted = binding.variables[states["position"]].variable.si_unit
    else:
        wanted = ""
    positions = frozenset(n for n in present if n in unit and wanted and unit[n] == wanted)
    alignments = {
        name: alignment_of(entry, is_position=name in positions) for name, entry in outputs.items()
    }
    factor = 1.0
    if "position" in states:
        factor = binding.variables[states["position"]].variable.to_si
    return Rig(position, positions, alignments, factor)


def _position_signal(binding: Binding, present: set[str]) -> str | None:
    """Output that tells the state `position`: the same variable, that name, or its unit."""
    outputs, state = binding.file.outputs, binding.file.states.get("position")
    candidates = [name for name in outputs if name in present]
    same = [name for name in candidates if outputs[name].variable == state]
    if same:
        return same[0]
    if "position" in candidates:
        return "position"
    if state is None:
        return None
    unit = binding.variables[state].variable.si_unit
    alike = [
        n
        for n in candidates
        if binding.variables[outputs[n].variable].variable.si_unit == unit and unit
    ]
    return alike[0] if alike else None


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
        What is scored.
    loop_time : float
        [s] Slowest time constant of the closed loop; a stretch is at least five long.
    nominal : sequence of Simulated, optional
        The twin as it is: a recording that starts elsewhere is scored once that is forgotten.
    positions : collection of str
        Signals by which that is told.

    Raises
    ------
    RecordingError
        Nothing is left to score.
    """
    windows: list[Window] = []
    total = sum(record.end - record.start for record in records)
    # Few or short recordings are cut finer, so that something can be left out of a fit.
    width = max(min(_WINDOW_S, total / _LEAST_WINDOWS), _LOOP_TIMES * loop_time)
    for k, record in enumerate(records):
        elsewhere = bool(nominal) and starts_elsewhere(record, nominal[k], positions, loop_time)
        found = [
            window
            for stretch in record.stretches(_SETTLING * loop_time, starts_elsewhere=elsewhere)
            for window in _windows_within(k, record, stretch, width)
        ]
        windows += found
    if not windows:
        raise RecordingError(
            f"expected at least {LEAST_ROWS} rows in a row after the start has been forgotten, "
            f"{_SETTLING * loop_time:.2g} s; got none; record longer, or without gaps"
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
    """Whether a recording starts at another place or speed than its twin.

    Within the first few rows neither parameters nor physics move anything that was at rest.

    Parameters
    ----------
    record : Record
        What was measured.
    nominal : Simulated
        The same by the twin as it is.
    positions : collection of str
        Signals by which that is told; a command differs by any load.
    loop_time : float
        [s] For which a wrong speed goes on.
    """
    for signal, values in zip(record.signals, nominal.signals, strict=True):
        if signal.name not in positions:
            continue
        apart = signal.values[:_FIRST_ROWS] - values[:_FIRST_ROWS]
        place = abs(float(np.median(apart)))
        moved = abs(float(apart[-1] - apart[0])) * loop_time / (_FIRST_ROWS * signal.spacing)
        noise = float(np.median(np.abs(np.diff(signal.values, 2))))
        bound = max(_ELSEWHERE * float(np.ptp(signal.values)), 3.0 * noise)
        if place > bound or moved > bound + noise * loop_time / signal.spacing:
            return True
    return False


def noise_runs(
    simulations: Simulations,
    point: Point,
    base: Sequence[Simulated],
    sigma: float | None,
    position: str | None,
    input_noise: Mapping[str, Sequence[float]],
    rng: np.random.Generator,
    resolution: float = 0.0,
) -> list[list[Direction]]:
    """Send noise of the recorded size through the loop: changes of each recording's signals.

    Parameters
    ----------
    simulations : Simulations
        Who runs the twin.
    point : Point
        Where.
    base : sequence of Simulated
        The same without noise.
    sigma : float or None
        [FMU's unit] Of the position's noise; None where it is not recorded.
    position : str or None
        Output that is the recorded position.
    input_noise : mapping of str to sequence of float
        [FMU's unit] Of recorded inputs, by the port at which they enter, for each recording.
    rng : numpy Generator
        Source of the noise.
    resolution : float
        [FMU's unit] Step of the encoder: an axis at rest stays on one count, whose error is no
        white noise.

    Returns
    -------
    list, one a recording, of up to NOISE_RUNS changes; empty where no port takes noise
    """
    ports = base[0].response.ports
    if sigma is None or (simulations.tracking is None and "sensor" not in ports):
        return [[] for _ in base]
    orders = []
    for k, record in enumerate(simulations.records):
        for _ in range(NOISE_RUNS):
            rows = record.plan.grid.size
            driven = {p: level[k] * rng.standard_normal(rows) for p, level in input_noise.items()}
            column = sensor_noise(base[k], position, sigma, resolution, rng)
            orders.append((k, column, driven))

    def one(
        order: tuple[int, NDArray[np.float64], dict[str, NDArray[np.float64]]],
    ) -> tuple[int, Direction | None]:
        k, column, driven = order
        if simulations.tracking is not None:
            run = simulations.run_one(point, k, measured_noise=column, excitation=driven)
        else:
            run = simulations.run_one(point, k, excitation={"sensor": column})
        if not run.finite:
            return k, None
        signals = run.signals
        if position is not None:
            if simulations.tracking is None:
                logged = _as_logged(run.response, base[k].response, position, column)
            else:
                # What is scored is recorded less simulated: the recording holds the noise.
                held = {**run.response.held, position: run.response.held[position] - column}
                logged = replace(run.response, held=held)
            signals = simulations.read(logged, k)
        return k, tuple(a - b for a, b in zip(signals, base[k].signals, strict=True))

    changes: list[list[Direction]] = [[] for _ in base]
    for k, change in simulations.map(one, orders):
        if change is not None:
            changes[k].append(change)
    return changes


def sensor_noise(
    base: Simulated,
    position: str | None,
    sigma: float,
    resolution: float,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """White noise and the error of an encoder's counts along a simulated motion, shape (rows,).

    Parameters
    ----------
    base : Simulated
        The motion.
    position : str or None
        Output that is the reading.
    sigma : float
        [FMU's unit] Standard deviation of both together.
    resolution : float
        [FMU's unit] Step of the encoder; 0 where it counts finely.
    rng : numpy Generator
        Source of the noise, and of where the counts lie.
    """
    rows = next(iter(base.response.held.values())).size
    white = rng.standard_normal(rows)
    counts = resolution / np.sqrt(12.0)
    if position is None or counts < _COARSE * sigma:
        return np.asarray(sigma * white)
    jitter = np.sqrt(max(sigma**2 - counts**2, 0.0))
    true = base.response.held[position] + resolution * rng.uniform(-0.5, 0.5)
    read = resolution * np.round((true + jitter * white) / resolution)
    return np.asarray(read - true)


def _as_logged(
    noisy: Response, quiet: Response, position: str, noise: NDArray[np.float64]
) -> Response:
    """Let a reading hold the noise of its own instant, as the logger and the controller see it.

    The output at t_k is read before the inputs of t_k act: where it contains the sensor port, it
    still holds the noise of the point before.
    """
    before = np.concatenate([noise[:1], noise[:-1]])
    change = noisy.held[position] - quiet.held[position]
    if float(change @ noise) > _CONTAINED * float(noise @ noise):
        return noisy
    contained = float(change @ before) / float(before @ before) > _CONTAINED
    reading = noisy.held[position] + noise - (before if contained else 0.0)
    return replace(noisy, held={**noisy.held, position: reading})


def covariances(
    windows: Sequence[Window],
    records: Sequence[Record],
    rig: Rig,
    own: Sequence[Sequence[float]],
    loop_noise: Sequence[Sequence[Direction]],
) -> list[Spectrum]:
    """S(f) of each window: loop noise, own noise, repeats, tolerance.

    Parameters
    ----------
    windows : sequence of Window
        What is scored.
    records : sequence of Record
        What was measured.
    rig : Rig
        Which signals are positions.
    own : sequence of sequences of float
        [SI unit squared] Variance of each signal's own noise, for each recording.
    loop_noise : sequence of sequences of Direction
        Changes under noise, of each recording.
    """
    total = []
    for window in windows:
        record = records[window.record]
        white = white_covariance(window, own[window.record])
        s = white + loop_covariance(window, loop_noise[window.record])
        s = s + _repeats(window, windows, records, s)
        total.append(s + tolerance_covariance(window, record, rig.positions))
    return total


def noise_squares(
    windows: Sequence[Window], records: Sequence[Record], rig: Rig, spectra: Sequence[Spectrum]
) -> tuple[float, ...]:
    """chi2 that noise alone gives in each window: S(f) holds a tolerance beside it.

    Parameters
    ----------
    windows : sequence of Window
        What is scored.
    records : sequence of Record
        What was measured.
    rig : Rig
        Which signals are positions.
    spectra : sequence of ndarray
        S(f) of each window.
    """
    found = []
    for window, s in zip(windows, spectra, strict=True):
        tolerance = tolerance_covariance(window, records[window.record], rig.positions)
        shares = 1.0 - np.real(np.einsum("fij,fji->f", np.linalg.inv(s), tolerance)) / s.shape[1]
        size = Whitener(window, s).n_residuals
        weights = np.mean(window.seen, axis=1)
        found.append(size * float(np.clip(np.sum(shares * weights) / np.sum(weights), 0.01, 1.0)))
    return tuple(found)


def white_variances(record: Record, noise: Mapping[str, NoiseLevel]) -> list[float]:
    """Variance of each signal's noise as if it were its own.

    Parameters
    ----------
    record : Record
        What was measured.
    noise : mapping of str to NoiseLevel
        White noise of each signal.
    """
    return [noise[signal.name].total ** 2 for signal in record.signals]


def own_variances(
    record: Record,
    noise: Mapping[str, NoiseLevel],
    loop_noise: Sequence[Direction],
    base: Simulated,
    position: str | None,
) -> list[float]:
    """Variance of each signal beyond what the loop makes of the sensor's noise.

    Parameters
    ----------
    record : Record
        What was measured.
    noise : mapping of str to NoiseLevel
        White noise of each signal.
    loop_noise : sequence of Direction
        Changes under the sensor's noise.
    base : Simulated
        The same without noise.
    position : str or None
        Signal that is the sensor's reading.
    """
    names = [signal.name for signal in record.signals]
    place = names.index(position) if position in names else None
    left = [s.values - run for s, run in zip(record.signals, base.signals, strict=True)]
    variances = []
    for i, signal in enumerate(record.signals):
        level = noise[signal.name]
        own = level.total**2
        through = 0.0
        if loop_noise:
            through = float(np.mean([fast_power(change[i]) for change in loop_noise]))
            own = max(own - through, 0.0)
            if place is not None and place != i and left[i].size == left[place].size:
                pairs = [(change[i], change[place]) for change in loop_noise]
                own = min(power_beside(left[i], left[place], pairs), level.total**2)
        # What went through the loop holds the reading's own resolution.
        least = level.least * (_SENT if through > 0.5 * level.total**2 else 1.0)
        variances.append(max(own, least**2))
    return variances


def _repeats(
    window: Window, windows: Sequence[Window], records: Sequence[Record], known: Spectrum
) -> Spectrum | float:
    first = records[window.record]
    excess = []
    for k, other in enumerate(records):
        if k == window.record or not _same_experiment(first, other):
            continue
        if [s.name for s in first.signals] == [s.name for s in other.signals]:
            excess.append(excess_of_repeats(window, first, other, known))
    return sum(excess) / len(excess) if excess else 0.0


def _same_experiment(a: Record, b: Record) -> bool:
    one, two = a.plan.experiment, b.plan.experiment
    if one.parameters.in_force != two.parameters.in_force or one.grid.size != two.grid.size:
        return False
    return all(
        np.allclose(one.inputs[name], two.inputs[name], rtol=0.0, atol=1e-12) for name in one.inputs
    )


def whiteners(
    windows: Sequence[Window],
    spectra: Sequence[Spectrum],
    directions: Sequence[Sequence[Direction]],
    dispersion: Sequence[NDArray[np.float64]] | None = None,
) -> tuple[Whitener, ...]:
    """Join budget and nuisances of each window.

    Parameters
    ----------
    windows : sequence of Window
        What is scored.
    spectra : sequence of ndarray
        S(f) of each window.
    directions : sequence of sequences of Direction
        Nuisances of each recording.
    dispersion : sequence of ndarray, optional
        Of each window: by how much its components exceed the budget.
    """
    spread = [None] * len(windows) if dispersion is None else dispersion
    return tuple(
        Whitener(window, s, dispersion=d).without(directions[window.record])
        for window, s, d in zip(windows, spectra, spread, strict=True)
    )


def nuisance_directions(
    simulations: Simulations,
    point: Point,
    base: list[Simulated],
    rig: Rig,
    torque_per_command: float,
) -> list[list[Direction]]:
    """Nuisances of each recording, about a simulated point.

    Parameters
    ----------
    simulations : Simulations
        Who runs the twin.
    point : Point
        Where.
    base : list of Simulated
        The recordings simulated there.
    rig : Rig
        Priors of the signals.
    torque_per_command : float
        Torque at the port for a unit of command.
    """

    def one(k: int) -> list[Direction]:
        record = simulations.records[k]
        own = record_directions(record, base[k], rig.alignments)
        return own + actuator_directions(simulations, point, base, k, torque_per_command)

    return list(simulations.map(one, range(len(base))))
