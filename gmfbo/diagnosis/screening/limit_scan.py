"""Limits of the actuator tried at many sizes at once, on the command as it was recorded.

A limit that cuts for a few milliseconds has a narrow minimum, which a handful of simulated sizes
misses. What it takes off is known from the recorded command itself; sent through the response
from the command port, it shows what it changed, without a simulation for each size.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.fitting.linear_left_out import square_after_refit
from gmfbo.diagnosis.fitting.misfit import Blocks
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.diagnosis.screening.port_response import PortResponse, measure_port_response
from gmfbo.diagnosis.screening.trials import least_square
from gmfbo.physics import CATALOGUE, States

Array = NDArray[np.float64]

_ROWS = (2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)  # beyond the limit, over all recordings
_FIRST_STEP = 0.005  # of a size, by which the best of them is first moved
_REFINING = 40  # sizes that are tried about it
_WORTH_REFINING = 0.3  # of what the best size explains
_SLOPES = (0.1, 0.25, 0.5, 1.0, 2.0)  # of the largest command per largest speed
_OCTAVES = 14  # of rates, down from the one by which the largest jump is followed at once
_ZONES = (1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1)  # of the largest command

SCANNED = (
    "actuator_saturation",
    "supply_voltage_limit",
    "actuator_rate_limit",
    "actuator_dead_zone",
)
"""Effects whose sizes are looked for on the recorded command."""


def scan_limits(
    case: Case, model: Fitted, rng: np.random.Generator, names: Sequence[str], least: float
) -> list[tuple[float, Candidate]]:
    """Best size of each limit, with what it explains; nothing where the command has no port.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    model : Fitted
        What is already explained.
    rng : numpy Generator
        Of the excitation that measures the response.
    names : sequence of str
        Effects that may be tried.
    least : float
        Fall of chi2 below which a size is not worth a fit.

    Returns
    -------
    list of (gain, Candidate), best first
    """
    wanted = [n for n in SCANNED if n in names]
    response = measure_port_response(case, "command", rng, model) if wanted else None
    if response is None:
        return []
    states = [
        _as_recorded(case, k, states_of(run, record))
        for k, (run, record) in enumerate(
            zip(model.simulated, case.simulations.records, strict=True)
        )
    ]

    def left(residual: Blocks) -> float:
        return square_after_refit(residual, model.sensitivity, model.prior)

    before = left(model.residual)

    def gain(name: str, values: Mapping[str, float]) -> float:
        return before - left(_without(case, model, response, states, name, values))

    found = []
    for name in wanted:
        tried = [_best(partial(gain, name), sizes) for sizes in _sizes(case, name, states)]
        most = max((value for value, _ in tried), default=0.0)
        if most <= least:
            continue
        best = max(tried, key=lambda entry: entry[0])[1]
        worth = [size for value, size in tried if value > max(least, _WORTH_REFINING * most)]
        between = [_refined(partial(gain, name), size) for size in worth]
        value, refined = max(((gain(name, size), size) for size in between), key=lambda e: e[0])
        found.append((max(value, most), _better(case, model, name, [refined, best])))
    return sorted(found, key=lambda entry: -entry[0])


def _best(
    gain: Callable[[Mapping[str, float]], float], sizes: Sequence[Mapping[str, float]]
) -> tuple[float, Mapping[str, float]]:
    return max(((gain(size), size) for size in sizes), key=lambda entry: entry[0])


def _better(
    case: Case, model: Fitted, name: str, sizes: Sequence[Mapping[str, float]]
) -> Candidate:
    """The size that explains more where it is simulated: the twin may ask for more elsewhere."""
    starts = [Candidate(name, values) for values in sizes]
    return min(starts, key=lambda start: least_square(case.misfit, model, start))


def _refined(
    gain: Callable[[Mapping[str, float]], float], start: Mapping[str, float]
) -> dict[str, float]:
    """The best size between those of the grid: from as little as 1 % off, a fit may not come."""
    names = list(start)
    sizes = np.array([start[n] for n in names])

    def loss(shares: Array) -> float:
        values = dict(zip(names, shares * sizes, strict=True))
        return -gain(values) if np.all(shares > 0.0) else 0.0

    corners = 1.0 + np.vstack([np.zeros(sizes.size), _FIRST_STEP * np.eye(sizes.size)])
    result = minimize(
        loss,
        corners[0],
        method="Nelder-Mead",
        options={"initial_simplex": corners, "maxfev": _REFINING},
    )
    return {n: float(v) for n, v in zip(names, result.x * sizes, strict=True)}


def _as_recorded(case: Case, k: int, states: States) -> States:
    """States with the command that was recorded: the limit took its share from that one."""
    file, record = case.twin.file, case.simulations.records[k]
    wanted = file.states.get("command")
    for signal in record.signals:
        entry = file.outputs[signal.name]
        if entry.variable == wanted and signal.driving is None:
            column = np.interp(record.plan.grid, signal.time, signal.values)
            if signal.name not in case.simulations.new_rows:
                column = np.concatenate([column[1:], column[-1:]])
            unit = case.twin.binding.variables[entry.variable].variable.to_si
            return replace(states, command=column / unit)
    return states


def _sizes(
    case: Case, name: str, states: Sequence[States]
) -> Iterator[Sequence[Mapping[str, float]]]:
    """Sizes in rows along which only one value changes."""
    command = np.concatenate([np.abs(s.command) for s in states])
    speed = np.concatenate([np.abs(s.velocity) for s in states])
    largest = float(command.max())
    if name == "actuator_saturation":
        limits = [{"limit": limit} for limit in _quantiles(command)]
        yield from [limits] if limits else []
    elif name == "actuator_dead_zone" and largest > 0.0:
        yield [{"width": share * largest} for share in _ZONES]
    elif name == "actuator_rate_limit":
        (rate,) = CATALOGUE[name].parameters
        fastest = rate.high(case.setting.excitation)
        yield [{"rate": fastest * 0.5**octave} for octave in range(_OCTAVES)]
    elif name == "supply_voltage_limit" and speed.any() and largest > 0.0:
        for share in _SLOPES:
            slope = share * largest / float(np.quantile(speed, 0.999))
            limits = [{"limit": v, "slope": slope} for v in _quantiles(command + slope * speed)]
            yield from [limits] if limits else []


def _quantiles(values: Array) -> list[float]:
    ordered = np.sort(values)[::-1]
    return [float(ordered[n]) for n in _ROWS if n < 0.5 * ordered.size and ordered[n] > 0.0]


def _without(
    case: Case,
    model: Fitted,
    response: PortResponse,
    states: Sequence[States],
    name: str,
    values: Mapping[str, float],
) -> Blocks:
    """Residual less what a limit of this size makes of the outputs."""
    changes = [response.filtered(k, _taken(name, own, values)) for k, own in enumerate(states)]
    columns = case.misfit.whitened(changes)
    return tuple(r - c for r, c in zip(model.residual, columns, strict=True))


def _taken(name: str, states: States, values: Mapping[str, float]) -> Array:
    """What a limit adds to each row of a command, on average over the row."""
    law = CATALOGUE[name]
    assert law.signal is not None, "limits have a signal"
    added = np.asarray(law.signal(states, values))
    return over_rows(states, added, values["rate"]) if "rate" in values else added


def over_rows(states: States, behind: Array, rate: float) -> Array:
    """What a rate limit adds to each row: within it, its output moves along a line to the command.

    Parameters
    ----------
    states : States
        Whose command it follows.
    behind : ndarray, shape (n,)
        [command] What it adds at the end of each row.
    rate : float
        [command/s]
    """
    reached = states.command + behind
    moved = np.diff(reached, prepend=states.command[:1])
    arrives = np.abs(moved) / (rate * states.step)  # share of the row for which it moves
    return np.asarray(behind - 0.5 * arrives * moved)
