"""What no law of the library holds: free functions of the states, at each port, beside a fit.

The smooth torque that every hypothesis has beside it is a function of the velocity and another of
the position. What is left may be fine, differ by direction, be a product of both, or act at
another port. Each of these is one more kind of inadequacy, with the same prior of its size.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from gmfbo.diagnosis.comparison.evidence import Grams, grams, log_evidences, weightings
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.inadequacy import inadequacy_columns, smooth, with_inadequacy
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.port_kernels import PortKernels, through
from gmfbo.diagnosis.comparison.problem import Problem

Array = NDArray[np.float64]

_FINE, _FINE_COMMAND, _COARSE = 40, 64, 8  # bumps over a state


@dataclass(frozen=True)
class Unknown:
    """What a fit most likely leaves that is no noise.

    Attributes
    ----------
    port : str
        Where it acts: `torque`, `command` or `sensor`.
    against : str
        State on which it depends: `position`, `velocity` or `command`.
    probability : float
        That it is more than twice what nobody cares about.
    log_odds : float
        [nats] Against nothing.
    """

    port: str
    against: str
    probability: float
    log_odds: float


@dataclass(frozen=True, eq=False)
class _Kind:
    """Unit signals at a port, by recording, shape (c, rows)."""

    port: str
    against: str
    signals: list[Array]


@dataclass(frozen=True, eq=False)
class _Seen:
    """A kind as it shows beside a fit."""

    port: str
    against: str
    inner: Grams
    count: int


def unknown_beside(
    problem: Problem, ledger: Ledger, row: Fitted, tolerance: float
) -> Unknown | None:
    """Tell what a fit leaves beside the noise of a ledger; None without a torque port.

    Parameters
    ----------
    problem : Problem
        Recordings.
    ledger : Ledger
        Whitening, and the paths from the ports.
    row : Fitted
        The fit.
    tolerance : float
        [FMU's unit of the torque port] Mean of the prior of the size.
    """
    kernels = ledger.kernels
    if "torque" not in kernels.kernels:
        return None
    whitening = row.beside_own_parts(ledger.whitening)
    usual = ledger.whitening(inadequacy_columns(problem, kernels, row))
    energy = _energy(usual)

    def seen(kind: _Kind) -> _Seen:
        white = ledger.whitening(_through_loop(problem, kernels, kind))
        unit = np.sqrt(energy / _energy(white)) if _energy(white) > 0.0 else 0.0
        scaled = [unit * one for one in white]
        inner = grams(problem, whitening, row, whitening.of_own(scaled))
        return _Seen(kind.port, kind.against, inner, len(white[0]))

    first = grams(problem, whitening, row, whitening.of_own(usual))
    found = [_Seen("torque", "velocity", first, len(usual[0]))]
    found += [seen(kind) for kind in _kinds(problem, kernels, row)]
    once = np.ones((1, len(first.squares)))
    logs, above = np.zeros(len(found)), np.zeros(len(found))
    for k, kind in enumerate(found):
        total, _, more = with_inadequacy(row, kind.inner, once, kind.count, tolerance)
        logs[k], above[k] = total[0], more[0]
    best = found[int(np.argmax(logs))]
    alone = float(log_evidences(row, first, once)[0])
    probability = float(np.exp(logs - logsumexp(logs)) @ above)
    # It has to be there whichever stretches are given more weight.
    weighted = with_inadequacy(
        row, best.inner, weightings(len(first.squares)), best.count, tolerance
    )[2]
    odds = float(logsumexp(logs) - np.log(len(found))) - alone
    return Unknown(best.port, best.against, min(probability, float(weighted.mean())), odds)


def _energy(columns: Sequence[Array]) -> float:
    return sum(float(np.sum(own**2)) for own in columns)


def _through_loop(problem: Problem, kernels: PortKernels, kind: _Kind) -> list[Array]:
    """What the unit signals of a kind cause, by segment, shape (c, m, n)."""
    made = []
    for segment in problem.segments:
        grid = problem.simulations.records[segment.record].plan.grid
        paths, signals = kernels.of(segment.record).kernels[kind.port], kind.signals[segment.record]
        columns = np.zeros((len(signals), len(segment.names), segment.time.size))
        for i, name in enumerate(segment.names):
            for c, answer in enumerate(through(signals, paths[name])):
                columns[c, i] = np.interp(segment.time, grid, answer)
        made.append(columns)
    return made


def _kinds(problem: Problem, kernels: PortKernels, row: Fitted) -> list[_Kind]:
    records = problem.simulations.records
    states = [run.response.states for run in row.runs]
    position = [s["position"] for s in states]
    velocity = [
        s["velocity"] if "velocity" in s else np.gradient(q, record.plan.grid)
        for s, q, record in zip(states, position, records, strict=True)
    ]
    fast = float(np.quantile(np.abs(np.concatenate(velocity)), 0.998)) or 1.0
    # Finer where friction changes: about standstill.
    speed = [np.sign(v) * np.sqrt(np.abs(v) / fast) for v in velocity]
    fine, coarse = _bumps_over(position, _FINE), _bumps_over(position, _COARSE)
    over_speed, coarse_speed = _bumps_over(speed, _FINE), _bumps_over(speed, _COARSE)
    by_direction = [_each_way(fine(q), v) for q, v in zip(position, velocity, strict=True)]
    kinds = [
        _Kind("torque", "position", by_direction),
        _Kind(
            "torque",
            "position",
            [fine(q) * v / fast for q, v in zip(position, velocity, strict=True)],
        ),
        _Kind("torque", "velocity", [_each_way(over_speed(s), np.gradient(s)) for s in speed]),
        _Kind(
            "torque",
            "velocity",
            [_products(coarse(q), coarse_speed(s)) for q, s in zip(position, speed, strict=True)],
        ),
    ]
    if all("command" in s for s in states) and "command" in kernels.kernels:
        command = [s["command"] for s in states]
        over_command = _bumps_over(command, _FINE_COMMAND)
        kinds.append(
            _Kind(
                "command", "command", [_each_way(over_command(u), np.gradient(u)) for u in command]
            )
        )
    if "sensor" in kernels.kernels:
        kinds.append(_Kind("sensor", "position", by_direction))
    return kinds


def _bumps_over(columns: Sequence[Array], count: int) -> Callable[[Array], Array]:
    """Smooth functions over the range that a state has in all recordings."""
    low, high = np.quantile(np.concatenate(columns), [0.002, 0.998])
    return lambda values: smooth(values, float(low), float(high), count)


def _each_way(bumps: Array, rate: Array) -> Array:
    """Functions of their own for each direction, shape (2 c, n)."""
    return np.concatenate([bumps * (rate > 0.0), bumps * (rate <= 0.0)])


def _products(first: Array, second: Array) -> Array:
    return (first[:, None] * second).reshape(-1, first.shape[1])
