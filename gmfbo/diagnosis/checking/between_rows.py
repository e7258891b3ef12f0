"""What inputs do between their rows, where the twin file does not say: held, or straight on.

A command of 20 ms rows that goes straight acts half a row sooner than one that is held, and a plant
driven the wrong way lacks a torque at each change of the command, which no law explains. A loop
answers its reference by itself: what it does between rows is an error of the simulation there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.checking.two_readings import slower_inputs, straight
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.numbers import named_log_odds
from gmfbo.diagnosis.comparison.opened_comparison import Comparison, comparison_of
from gmfbo.diagnosis.comparison.row_fits import values_in
from gmfbo.errors import GmfboError
from gmfbo.plain_words import listed
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin

_BARE = frozenset[str]()


@dataclass(frozen=True, eq=False)
class Driven:
    """A case, and how its inputs were taken from the recordings.

    Attributes
    ----------
    case : Case
        Opened with them.
    recordings : tuple of Recording
        As they drive the twin.
    late : tuple of str
        Inputs that are taken a row sooner than they were logged.
    """

    case: Case
    recordings: tuple[Recording, ...]
    late: tuple[str, ...] = ()


def driven_as_likelier(
    case: Case,
    recordings: Sequence[Recording],
    opened: Callable[[FmuTwin, Sequence[Recording]], Case],
) -> Driven:
    """A case of an open-loop plant whose unstated inputs go as is likeliest.

    They are held, or go straight to the next row, or either a row sooner, of a logger that writes
    them late. Such an input acts before it is seen, which no law explains; one that is logged early
    is an actuator's delay. The bare twin is asked, beside an inadequacy of any size.

    Parameters
    ----------
    case : Case
        Opened with inputs that are held.
    recordings : sequence of Recording
        Of the case.
    opened : callable (FmuTwin, sequence of Recording) -> Case
        Opens recordings with another twin.

    Returns
    -------
    Driven
        The likeliest case; others are closed.
    """
    kept = Driven(case, tuple(recordings))
    names = [name for name in slower_inputs(case.twin, recordings) if _is_real(case.twin, name)]
    if not names or case.simulations.tracking is None:
        return kept
    drawn, sooner = straight(case.twin, names), a_row_sooner(recordings, names)
    for twin, given, late in (
        (drawn, recordings, ()),
        (case.twin, sooner, tuple(names)),
        (drawn, sooner, tuple(names)),
    ):
        kept = _likelier(kept, partial(opened, twin, given), given, late)
    return kept


def a_row_sooner(recordings: Sequence[Recording], names: Sequence[str]) -> tuple[Recording, ...]:
    """Recordings in which each row of some signals has the value of the next one.

    Parameters
    ----------
    recordings : sequence of Recording
        Runs of the real axis.
    names : sequence of str
        Signals; the last value stays.
    """

    def moved(column: NDArray[np.float64]) -> NDArray[np.float64]:
        sooner, known = column.copy(), np.flatnonzero(np.isfinite(column))
        sooner[known[:-1]] = column[known[1:]]
        return sooner

    return tuple(
        replace(
            one,
            signals={n: moved(c) if n in names else c for n, c in one.signals.items()},
        )
        for one in recordings
    )


def _likelier(
    kept: Driven,
    opened: Callable[[], Case],
    recordings: Sequence[Recording],
    late: tuple[str, ...],
) -> Driven:
    """The likelier of a case and another one; the less likely one is closed."""
    other, case = None, kept.case
    try:
        other = opened()
        found = Driven(other, tuple(recordings), late) if _is_likelier(other, case) else kept
    except GmfboError:
        found = kept  # driven so the twin does not run
    except BaseException:
        case.simulations.close()
        if other is not None:
            other.simulations.close()
        raise
    if other is not None:
        left = case if found.case is other else other
        found.case.simulations.runs += left.simulations.runs
        left.simulations.close()
    return found


def straight_inputs(twin: FmuTwin, given: FmuTwin) -> list[str]:
    """Inputs that go straight from row to row in a twin, and are held in the one that was given.

    Parameters
    ----------
    twin, given : FmuTwin
        With the same inputs.
    """
    return [
        name
        for name, entry in twin.file.inputs.items()
        if entry.interpolation != given.file.inputs[name].interpolation
    ]


def note_of_straight(names: Sequence[str], late: Sequence[str] = ()) -> list[str]:
    """Say what was done, and how the twin file says it; nothing where nothing was done.

    Parameters
    ----------
    names : sequence of str
        From `straight_inputs`.
    late : sequence of str
        Inputs that are taken a row sooner than they were logged.
    """
    told = []
    if late:
        told.append(
            f"{listed(late)}: taken one row sooner than it was logged, which the recordings like "
            "better: the logger writes that column late"
        )
    if names:
        told.append(
            f"{listed(names)}: driven straight from row to row, which the recordings like better "
            'than held; write interpolation = "linear" there, or "hold" if it is held'
        )
    return told


def _is_real(twin: FmuTwin, name: str) -> bool:
    entry = twin.file.inputs[name]
    return twin.binding.variables[entry.variable].variable.type in ("Real", "Float64", "Float32")


def _is_likelier(one: Case, other: Case) -> bool:
    """Whether a case's twin without laws is clearly likelier, each at the likeliest levels found.

    Levels are found from where each fit is, and may end far from the likeliest ones.
    """
    windows = other.budget.windows
    asked = [
        comparison_of(replace(c, budget=replace(c.budget, windows=windows)), ())
        for c in (one, other)
    ]
    found = [comparison.search.opened(comparison.first) for comparison in asked]
    if len({values_in(ledger.rows[_BARE]) for ledger in found}) > 1:
        return False  # other rows are compared: the odds would be of these
    first, second = (
        _evidence(comparison, ledger, found)
        for comparison, ledger in zip(asked, found, strict=True)
    )
    return first > second + named_log_odds()


def _evidence(comparison: Comparison, ledger: Ledger, found: Sequence[Ledger]) -> float:
    """[nats] Log evidence of the bare twin, at the likeliest of some levels."""
    row = ledger.rows[_BARE]
    return max(
        comparison.search.evidence_alone(row, replace(ledger, levels=under.levels))
        for under in found
    )
