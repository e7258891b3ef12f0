"""Of many starts of a limit, those that what the twin leaves points to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.inadequacy import through_loop
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.moves import Element, start_gains
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.physics.effect import Values
from gmfbo.physics.states import States

Array = NDArray[np.float64]

_SIMULATED = 12  # starts of an effect at most


def pointed_starts(
    problem: Problem, ledger: Ledger, elements: Sequence[Element]
) -> tuple[Element, ...]:
    """Elements, of whose many starts only those stay to which the bare twin's residual points.

    A limit that is met for milliseconds is met at one instant, and its starts are as many as the
    motion has large demands. What each cuts of the command leads to the signals by the linear
    path of its port, and nothing is simulated.

    Parameters
    ----------
    problem : Problem
        Recordings.
    ledger : Ledger
        With the bare twin, the paths from the ports and the whitening.
    elements : sequence of Element
        At their starts, those of an effect together.
    """
    about, found = ledger.rows[frozenset()], list[Element]()
    for _, group in groupby(elements, key=lambda element: element.name):
        own = list(group)
        law = own[0].candidate.law if own[0].candidate else None
        if law and len(own) > _SIMULATED and law.signal and law.port in ledger.kernels.kernels:
            signals = _signals(problem, about, law.signal, own)
            columns = through_loop(problem, ledger.kernels, law.port, signals)
            gains = start_gains(ledger.whitening, about, columns)
            own = [own[i] for i in np.argsort(-gains)[:_SIMULATED]]
        found += own
    return tuple(found)


def _signals(
    problem: Problem,
    about: Fitted,
    signal: Callable[[States, Values], Array],
    elements: Sequence[Element],
) -> list[Array]:
    """What an effect does at its port at each start, by recording, shape (k, rows)."""
    values = [element.candidate.values for element in elements if element.candidate]
    runs = zip(about.runs, problem.simulations.records, strict=True)
    states = [states_of(run, record) for run, record in runs]
    return [np.array([signal(own, one) for one in values]) for own in states]
