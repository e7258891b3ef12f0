"""Whether the rows of each recording hold the command still in force or the one just computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.checking.compared_command import ComparedCommand
from gmfbo.diagnosis.locating.parities import CLEARLY, Parities

_HALF = 0.5  # of a row: a command that is shifted by more is late or early, whatever rows hold


@dataclass(frozen=True)
class RowConvention:
    """Convention that a recording's command shows by the controller's parity.

    Attributes
    ----------
    which : str
        `held` or `new`, whichever leaves less.
    least, most : float
        Share of the command's power that this one and the other one leave.
    is_clear : bool
        Whether the other one leaves clearly more, and no shift by a row explains it better.
    """

    which: str
    least: float
    most: float
    is_clear: bool


def row_conventions(case: Case, checked: Parities) -> list[RowConvention | None]:
    """Convention of each recording; None where both leave the same, or nothing was checked.

    Parameters
    ----------
    case : Case
        At nominal parameters.
    checked : Parities
        Runs of the twin that was held on its recordings.
    """
    command = command_of(case)
    if checked.controller is None or command is None or not checked.logged:
        return [None] * len(case.simulations.records)
    return [_convention(case, checked, k, command) for k in range(len(checked.held))]


def _convention(case: Case, checked: Parities, k: int, command: str) -> RowConvention | None:
    run = checked.held[k].response
    compared = {
        which: ComparedCommand(case, k, command, which, checked.memories[k])
        for which in ("held", "new")
    }
    left = {which: own.share_left(run) for which, own in compared.items()}
    if left["held"] == left["new"]:
        return None
    which = min(left, key=lambda one: left[one])
    least, most = sorted(left.values())
    own = compared[which]
    is_in_time = abs(own.shift_left(own.computed(run))) < _HALF * own.row
    return RowConvention(which, least, most, most > CLEARLY * least and is_in_time)


def common_convention(told: Sequence[RowConvention | None], *, fails: bool) -> str | None:
    """Convention of all recordings by the clearest one; None where none is clear.

    A sum over all recordings would be misled by one with a shifted column.

    Parameters
    ----------
    told : sequence of RowConvention or None
        By recording.
    fails : bool
        Whether the controller computes something else than was recorded.
    """
    known = [own for own in told if own is not None]
    if not known:
        return None
    best = min(known, key=lambda own: own.least)
    # Beside an error as large as that of a wrong controller, the smaller residual is chance.
    return best.which if not fails or best.most > CLEARLY * best.least else None


def are_mixed(told: Sequence[RowConvention | None]) -> bool:
    """Whether some recordings clearly hold the held and others the new command.

    Parameters
    ----------
    told : sequence of RowConvention or None
        By recording.
    """
    return len({own.which for own in told if own is not None and own.is_clear}) > 1
