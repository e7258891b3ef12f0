"""The law that a free function looks like: no claim, but what one would say of its curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.numbers import MOST
from gmfbo.diagnosis.comparison.unknown.beside import Unknown
from gmfbo.diagnosis.naming.decision import Compared
from gmfbo.diagnosis.result.explained import Resembled
from gmfbo.diagnosis.runs.simulated import Simulated

Array = NDArray[np.float64]

_ROUNDING = 1e-12  # of a signal's square: less is nothing


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
    plain = np.concatenate([_plain(run, port) for run in function.left.runs], axis=1)
    found = []
    for elements, row in compared.ledger.rows.items():
        effects = row.hypothesis.effects
        if len(elements) != 1 or len(effects) != 1 or effects[0].law.port != port:
            continue
        law = np.concatenate([acting(run, port) for run in row.runs])
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
    if np.any(np.diag(squares) <= _ROUNDING * np.sum(both**2, axis=0)):
        return 0.0
    return max(float(squares[0, 1]), 0.0) ** 2 / float(squares[0, 0] * squares[1, 1])


def acting(run: Simulated, port: str) -> Array:
    """What acts at a port, without the loop that holds an open-loop twin.

    Parameters
    ----------
    run : Simulated
        A simulated recording.
    port : str
        One that the twin has.
    """
    added = run.response.ports[port]
    return added - run.response.effort if port == "torque" else added


def _plain(run: Simulated, port: str) -> Array:
    """A constant, and what a twin's own parameters make at the port, shape (n, rows)."""
    states, position = run.response.states, run.response.states["position"]
    if port == "torque":
        velocity = states.get("velocity", np.gradient(position))
        columns = [velocity, np.gradient(velocity)]
    else:
        columns = [states.get("command", position) if port == "command" else position]
    return np.stack([np.ones(position.size), *columns])
