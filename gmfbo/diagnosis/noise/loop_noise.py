"""Sensor noise carried by the loop to every signal, and each signal's own noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.noise_levels import (
    NoiseLevel,
    fast_power,
    power_beside,
)
from gmfbo.diagnosis.scoring.nuisances import Direction
from gmfbo.sources.twin.response import Response

NOISE_RUNS = 4
"""Noise runs of each recording; few are enough, since spectra are smoothed over frequency."""

_CONTAINED = 0.5  # of the sensor port's noise: a reading that shows more contains the port
_SENT = 0.1  # of a resolution: own noise that remains where the loop's noise contains the rounding
_COARSE = 0.3  # of a position's noise: a smaller counting error is taken as white


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
    """Send noise of the recorded size through the loop, and return the signals' changes.

    Parameters
    ----------
    simulations : Simulations
        Simulators of the twin.
    point : Point
        Values at which the twin runs.
    base : sequence of Simulated
        The recordings simulated without noise.
    sigma : float or None
        [FMU's unit] Standard deviation of the position's noise; None where none is recorded.
    position : str or None
        Output that is the recorded position.
    input_noise : mapping of str to sequence of float
        [FMU's unit] Noise of recorded inputs by their port, for each recording.
    rng : numpy Generator
        Source of the noise.
    resolution : float
        [FMU's unit] Step of the encoder: an axis at rest stays on one count, and its error is not
        white.

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
        return k, _change(simulations, k, base[k], run, position, column)

    made = simulations.map(one, orders)
    return [[c for k, c in made if k == i and c is not None] for i in range(len(base))]


def _change(
    simulations: Simulations,
    k: int,
    quiet: Simulated,
    noisy: Simulated,
    position: str | None,
    noise: NDArray[np.float64],
) -> Direction | None:
    """Change of the signals as they are logged under sensor noise; None without a result."""
    if not noisy.finite:
        return None
    signals = noisy.signals
    if position is not None:
        if simulations.tracking is None:
            logged = _as_logged(noisy.response, quiet.response, position, noise)
        else:
            # The residual is recorded less simulated, and the recording holds the noise.
            held = {**noisy.response.held, position: noisy.response.held[position] - noise}
            logged = replace(noisy.response, held=held)
        signals = simulations.read(logged, k)
    return tuple(a - b for a, b in zip(signals, quiet.signals, strict=True))


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
        Source of the noise, and of the position of the counts.
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
    """Shift a reading's noise to its own instant, as the logger and the controller see it.

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


def white_variances(record: Record, noise: Mapping[str, NoiseLevel]) -> list[float]:
    """Variance of each signal's noise, with none of it ascribed to the loop."""
    return [noise[signal.name].total ** 2 for signal in record.signals]


def own_variances(
    record: Record,
    noise: Mapping[str, NoiseLevel],
    loop_noise: Sequence[Direction],
    base: Simulated,
    position: str | None,
) -> list[float]:
    """Variance of each signal's noise beyond the sensor noise carried by the loop.

    Parameters
    ----------
    record : Record
        Recording that is scored.
    noise : mapping of str to NoiseLevel
        White noise of each signal.
    loop_noise : sequence of Direction
        Changes of the signals under the sensor's noise.
    base : Simulated
        The recording simulated without noise.
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
        # Noise carried by the loop already contains the reading's resolution.
        least = level.least * (_SENT if through > 0.5 * level.total**2 else 1.0)
        variances.append(max(own, least**2))
    return variances
