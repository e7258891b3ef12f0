"""Take the last told run of a study back; everything stays on disk."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gmfbo.errors import InputError
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.history.standing import UNDO, StandingStore
from gmfbo.tuning.study.study import Study

if TYPE_CHECKING:
    from gmfbo.recordings.store.memory_store import TrialStore


@dataclass(frozen=True)
class TakenBack:
    """A told run that counts no more.

    Attributes
    ----------
    trial : Trial
        The run.
    followers : int
        Number of twin runs that were made because of it, which count no more either.
    again : int
        Number of the trial that asks for the same gains again.
    """

    trial: Trial
    followers: int
    again: int


def take_back(study: Study) -> TakenBack:
    """Take back the run that was told last.

    It, the runs made because of it, and the versions of the twin since stay on disk and count no
    more. Its gains are asked for again; what was asked for since is withdrawn.

    Parameters
    ----------
    study : Study
        Begun.

    Raises
    ------
    InputError
        No told run is left.
    StoreError
        The study's folder cannot be written.
    """
    if not study.begun:
        raise InputError(f"{study.location}: nothing was told yet, so nothing can be taken back")
    with study.open_for_writing(resume=True) as store:
        return _take_back(store)


def _take_back(store: TrialStore) -> TakenBack:
    standing = StandingStore(store)
    trials, events = standing.trials(), standing.events()
    told = [event for event in events if event["event"] == "tell"]
    if not told:
        raise InputError(f"{store.location}: no told run is left that could be taken back")
    number = told[-1]["number"]
    trial = next(one for one in trials if one.number == number)
    followers = [one.number for one in trials if one.parent == number]
    since = events[events.index(told[-1]) :]
    for version in [event for event in since if event["event"] == "twin_version"]:
        _set_aside(store.location / "twins", version, number)
    store.log(UNDO, number=number, trials=[number, *followers])
    asked = [e for e in events if e["event"] == "ask" and e["number"] == number][-1]
    again: dict[str, Any] = {
        "number": max(standing.highest, *_waiting(standing), 0) + 1,
        "source": "IS1",
        "gains": asked["gains"],
        "mismatch": asked["mismatch"],
        "note": f"asked again: trial {number} was taken back",
        "expected": asked.get("expected"),
        "real": sum(one.source == "IS1" for one in standing.trials()),
    }
    store.log("ask", **again)
    store.refresh_index()
    return TakenBack(trial, len(followers), again["number"])


def _waiting(standing: StandingStore) -> list[int]:
    """Numbers that were asked for and are still waited for."""
    asked = [event["number"] for event in standing.events() if event["event"] == "ask"]
    return [number for number in asked if number not in standing.numbers]


def _set_aside(folder: Path, version: dict[str, Any], number: int) -> None:
    """Rename the files of a twin's version, so that the next one of its number keeps them."""
    for path in sorted(folder.glob(f"{version['version']:05d}*")):
        path.rename(path.with_name(f"taken_back_{number}_{path.name}"))
