"""The law that a free function looks like: no claim, but what one would say of its curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.inadequacy import motion_of
from gmfbo.diagnosis.comparison.numbers import MOST
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.unknown.beside import Unknown
from gmfbo.diagnosis.naming.decision import Compared
from gmfbo.diagnosis.result.explained import Resembled
from gmfbo.diagnosis.runs.simulated import Simulated

Array = NDArray[np.float64]


def resembled_law(compared: Compared, unknown: Unknown) -> Resembled | None:
    """Find the law of the library that makes most of a free function, in proportion.

    Parameters
    ----------
    compared : Compared
        Laws as they were fitted one by one.
    unknown : Unknown
        What no law holds.

    Returns
    -------
    Resembled or None
        None where no law at that port makes more than half of it.
    """
    function, port = unknown.function.fitted, unknown.port
    made = np.concatenate([function.amplitudes @ own for own in function.kind.signals])
    plain = _plain(unknown.function.problem, function.left, port)
    found = []
    for elements, row in compared.ledger.rows.items():
        effects = row.hypothesis.effects
        if len(elements) != 1 or len(effects) != 1 or effects[0].law.port != port:
            continue
        law = np.concatenate([_acting(run, port) for run in row.runs])
        found.append((share_made(made, law, plain), effects[0].effect))
    share, name = max(found, default=(0.0, ""))
    return Resembled(name, share) if share > MOST else None


def share_made(made: Array, law: Array, plain: Array) -> float:
    """Share of a signal's square that a law makes in proportion, beside some plain signals.

    Parameters
    ----------
    made, law : ndarray, shape (rows,)
        The signal, and that of the law.
    plain : ndarray, shape (n, rows)
        Signals of which neither counts.
    """
    both = np.stack([made, law], axis=1)
    rest = both - plain.T @ np.linalg.lstsq(plain.T, both, rcond=None)[0]
    squares = rest.T @ rest
    rounding = made.size * np.finfo(made.dtype).eps * np.sum(both**2, axis=0)
    if np.any(np.diag(squares) <= rounding):
        return 0.0
    return max(float(squares[0, 1]), 0.0) ** 2 / float(squares[0, 0] * squares[1, 1])


def _acting(run: Simulated, port: str) -> Array:
    """What acts at a port, without the loop that holds an open-loop twin."""
    added = run.response.ports[port]
    return added - run.response.effort if port == "torque" else added


def _plain(problem: Problem, fitted: Fitted, port: str) -> Array:
    """A constant, and what a twin's own parameters make at the port, shape (n, rows)."""
    if port == "torque":
        velocities = motion_of(problem, fitted).velocities
        columns = [velocities, [np.gradient(own) for own in velocities]]
    else:
        state = "command" if port == "command" else "position"
        columns = [[run.response.states[state] for run in fitted.runs]]
    joined = [np.concatenate(column) for column in columns]
    return np.stack([np.ones(joined[0].size), *joined])
