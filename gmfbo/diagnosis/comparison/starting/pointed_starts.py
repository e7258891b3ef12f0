"""Of an effect's many further starts, those to which what the bare twin leaves points."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.inadequacy import through_loop
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.moves import Element, start_gains
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.physics.effect import Values
from gmfbo.physics.states import States

Array = NDArray[np.float64]

_PICKED = 6  # further starts of an effect, at most


def pointed_starts(
    problem: Problem, ledger: Ledger, elements: Sequence[Element]
) -> tuple[Element, ...]:
    """Further starts of effects, those that gain most about the bare twin.

    A limit that is met for milliseconds is met at one instant, and it may begin at each of the
    motion's large demands. What it cuts of the command there leads to the signals by the linear
    path of its port, and nothing is simulated.

    Parameters
    ----------
    problem : Problem
        Recordings.
    ledger : Ledger
        With the bare twin, the paths from the ports and the whitening.
    elements : sequence of Element
        At their usual starts.
    """
    base, found = ledger.rows[frozenset()], list[Element]()
    excitation = base.hypothesis.setting.excitation
    laws = {e.name: e.candidate.law for e in elements if e.candidate is not None}
    for name, law in laws.items():
        starts = law.more_starts(excitation)
        if not starts or law.signal is None or law.port not in ledger.kernels.simulated:
            continue
        signals = _signals(problem, base, law.signal, starts)
        paths = (problem, ledger.kernels, law.port, signals)
        gains = start_gains(ledger.whitening, base, through_loop(*paths, as_simulated=True))
        for i in np.argsort(-gains)[:_PICKED]:
            if gains[i] > 0.0:
                candidate = Candidate(name, dict(starts[i])).with_nuisances(excitation)
                found.append(Element(candidate=candidate))
    return tuple(found)


def _signals(
    problem: Problem,
    about: Fitted,
    signal: Callable[[States, Values], Array],
    starts: Sequence[Values],
) -> list[Array]:
    """What an effect does at its port at each start, by recording, shape (k, rows)."""
    runs = zip(about.runs, problem.simulations.records, strict=True)
    states = [states_of(run, record) for run, record in runs]
    return [np.array([signal(own, values) for values in starts]) for own in states]
