"""What no law of the library holds: free functions of the states, at each port, beside a fit.

The smooth torque that every hypothesis has beside it is a function of the velocity and another of
the position. What is left may be fine, differ by direction, be a product of both, or act at
another port. Each of these is one more kind of inadequacy, with the same prior of its size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from gmfbo.diagnosis.comparison.evidence import Grams, grams, log_evidences, weightings
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.inadequacy import (
    ends_of,
    inadequacy_columns,
    motion_of,
    smooth,
    through_loop,
    with_inadequacy,
)
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
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
        white = ledger.whitening(through_loop(problem, kernels, kind.port, kind.signals))
        own = _energy(white)
        unit = np.sqrt(energy / own) if own > 0.0 else 0.0
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


def _kinds(problem: Problem, kernels: PortKernels, row: Fitted) -> list[_Kind]:
    motion = motion_of(problem, row)
    fine, coarse = _over(motion.positions, _FINE), _over(motion.positions, _COARSE)
    coarse_speed = _over(motion.speeds, _COARSE)
    by_direction = _each_way(fine, motion.velocities)
    over_speed = _over(motion.speeds, _FINE)
    kinds = [
        _Kind("torque", "position", by_direction),
        _Kind(
            "torque",
            "position",
            [b * v / motion.fast for b, v in zip(fine, motion.velocities, strict=True)],
        ),
        _Kind("torque", "velocity", _each_way(over_speed, [np.gradient(s) for s in motion.speeds])),
        _Kind(
            "torque",
            "velocity",
            [_products(a, b) for a, b in zip(coarse, coarse_speed, strict=True)],
        ),
    ]
    states = [run.response.states for run in row.runs]
    if all("command" in s for s in states) and "command" in kernels.kernels:
        command = [s["command"] for s in states]
        rates = [np.gradient(u) for u in command]
        kinds.append(_Kind("command", "command", _each_way(_over(command, _FINE_COMMAND), rates)))
    if "sensor" in kernels.kernels:
        kinds.append(_Kind("sensor", "position", by_direction))
    return kinds


def _over(columns: Sequence[Array], count: int) -> list[Array]:
    """Smooth functions over the range that a state has in all recordings, shape (count, n)."""
    low, high = ends_of(columns)
    return [smooth(values, low, high, count) for values in columns]


def _each_way(bumps: Sequence[Array], rates: Sequence[Array]) -> list[Array]:
    """Functions of their own for each direction, shape (2 c, n)."""
    return [
        np.concatenate([own * (rate > 0.0), own * (rate <= 0.0)])
        for own, rate in zip(bumps, rates, strict=True)
    ]


def _products(first: Array, second: Array) -> Array:
    return (first[:, None] * second).reshape(-1, first.shape[1])
