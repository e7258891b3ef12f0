"""Propose a recording that tells rivals apart, or excites effects not excited so far."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.experiment.menu_runs import (
    Menu,
    make_menu,
    play,
    playing,
    reference_input,
)
from gmfbo.diagnosis.experiment.outcome_words import predicted_outcome
from gmfbo.diagnosis.experiment.separation import ENOUGH, Separation, separations
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.naming.open_explanations import name_of
from gmfbo.diagnosis.result.next_experiment import NextExperiment
from gmfbo.diagnosis.runs.measured_excitation import reversals, states_of
from gmfbo.physics import CATALOGUE, Excitation, States
from gmfbo.plain_words import words
from gmfbo.recordings.writing.writer import write_recording

FILE_NAME = "next.csv"


def propose(
    case: Case, rivals: Sequence[Fitted], folder: Path | None = None, enough: float = ENOUGH
) -> NextExperiment | None:
    """Choose the reference on which refitted rivals differ most.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    rivals : sequence of Fitted
        Hypotheses that the recordings cannot tell apart, likeliest first.
    folder : Path or None
        Where `next.csv` is written; None writes nothing.
    enough : float
        [nats] Log odds from which two rivals are told apart.

    Returns
    -------
    NextExperiment or None
        None where there are no two rivals or no reference that a drive could play.
    """
    reference = reference_input(case)
    if reference is None or len(rivals) < 2:
        return None
    menu = make_menu(case, rivals[0], reference)
    names = rival_names(rivals, {u.name for u in case.setting.uncertain})
    with playing(case, menu):
        played = [play(case, rival) for rival in rivals] if menu.entries else []
        runs = {n: p for n, p in zip(names, played, strict=False) if p is not None}
        if len(runs) < 2:
            return None
        plays = [(entry,) for entry in range(len(menu.entries))]
        best = max(separations(case, menu, runs, plays), key=lambda one: one.worth(enough))
        (entry,) = best.plays
        told = {
            name: predicted_outcome(case, menu.records[entry], name, entry, runs) for name in runs
        }
    motion = menu.entries[entry].words
    if not best.told_apart(enough):
        return _in_vain(motion, best, enough, told)
    return _telling_apart(motion, best, enough, told, _write(menu, entry, folder))


def propose_for(
    case: Case, base: Fitted, effects: Sequence[str], folder: Path | None = None
) -> NextExperiment | None:
    """Choose the reference that excites most of the effects that were not excited.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    base : Fitted
        The model that predicts how the axis will move.
    effects : sequence of str
        Names in the catalogue.
    folder : Path or None
        Where `next.csv` is written; None writes nothing.

    Returns
    -------
    NextExperiment or None
        None where there is nothing to excite or no reference that a drive could play.
    """
    reference = reference_input(case)
    if reference is None or not effects:
        return None
    menu = make_menu(case, base, reference)
    if not menu.entries:
        return None
    with playing(case, menu):
        runs = case.simulations.run([base.hypothesis.point(base.x)])[0]
        shown = []
        for record, run in zip(menu.records, runs, strict=True):
            excitation = _with_entry(
                case.setting.excitation, states_of(run, record), finite=run.finite
            )
            shown.append([n for n in effects if CATALOGUE[n].not_excited(excitation) is None])
    best = max(range(len(shown)), key=lambda e: len(shown[e]))
    if not shown[best]:
        why = "; ".join(
            f"{words(n)}: {CATALOGUE[n].not_excited(case.setting.excitation)}" for n in effects
        )
        said = f"no reference within the recorded range and speed excites them: {why}"
        return NextExperiment("", (), 0.0, 0.0, {}, said)
    listed = ", ".join(words(name) for name in shown[best])
    why = f"{menu.entries[best].words}, played twice, excites what was not: {listed}"
    return NextExperiment(_write(menu, best, folder), tuple(shown[best]), 0.0, 0.0, {}, why)


def rival_names(rivals: Sequence[Fitted], uncertain: Collection[str]) -> list[str]:
    """Name of each rival: what it adds to the refitted twin, or `parameters`; each name once.

    Parameters
    ----------
    rivals : sequence of Fitted
        Fits to the same recordings.
    uncertain : collection of str
        Parameters that all of them refit.
    """
    names: list[str] = []
    for rival in rivals:
        name = name_of(rival, uncertain)
        alike = sum(other.partition(" (")[0] == name for other in names)
        names.append(f"{name} ({alike + 1})" if alike else name)
    return names


def _with_entry(excitation: Excitation, states: States, *, finite: bool) -> Excitation:
    """Excitation by the recordings and one entry of the menu together."""
    if not finite:
        return excitation
    speed = float(np.quantile(np.abs(states.velocity), 0.995))
    duration = float(states.time[-1] - states.time[0])
    return replace(
        excitation,
        reversals=excitation.reversals + reversals(states),
        stroke=max(excitation.stroke, float(np.ptp(states.position))),
        speed=max(excitation.speed, speed),
        duration=max(excitation.duration, duration),
        total=excitation.total + duration,
    )


def _telling_apart(
    motion: str, best: Separation, enough: float, told: Mapping[str, str], file: str
) -> NextExperiment:
    apart = best.told_apart(enough)
    names = tuple(n for n in told if any(n in pair for pair in apart))
    why = f"{motion}, played twice, is where they differ most on the menu"
    together = [f"{a} and {b}" for a, b in best.log_odds if (a, b) not in apart]
    if together:
        why += f"; it does not tell apart {words('; '.join(together))}"
    return NextExperiment(file, names, min(apart.values()), enough, told, why)


def _in_vain(
    motion: str, best: Separation, enough: float, told: Mapping[str, str]
) -> NextExperiment:
    largest = max(best.log_odds.values())
    why = (
        "no experiment on the menu separates them: the largest predicted log odds are "
        f"{largest:.3g} with {motion}, {enough:.3g} would be needed"
    )
    return NextExperiment("", (), largest, enough, told, why)


def _write(menu: Menu, entry: int, folder: Path | None) -> str:
    if folder is not None:
        write_recording(menu.references[entry], Path(folder) / FILE_NAME)
    return FILE_NAME
