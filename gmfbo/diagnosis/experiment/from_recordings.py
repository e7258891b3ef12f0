"""Propose a recording that tells rivals apart, or excites effects not excited so far."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.experiment.choice import Size, choose
from gmfbo.diagnosis.experiment.menu_runs import joined, make_menu, playing, reference_input
from gmfbo.diagnosis.experiment.outcome_words import predicted_outcomes
from gmfbo.diagnosis.experiment.separation import ENOUGH, Plays
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.naming.open_explanations import name_of
from gmfbo.diagnosis.result.next_experiment import NextExperiment
from gmfbo.diagnosis.runs.measured_excitation import reversals, states_of
from gmfbo.physics import CATALOGUE, Excitation, States
from gmfbo.plain_words import words
from gmfbo.recordings.writing.writer import write_recording

FILE_NAME = "next.csv"


def propose(
    case: Case,
    rivals: Sequence[Fitted],
    effects: Sequence[str] = (),
    folder: Path | None = None,
) -> NextExperiment | None:
    """Choose the reference on which rivals differ most, or that excites most effects.

    It goes no farther, faster or harder than the recordings.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    rivals : sequence of Fitted
        Hypotheses that the recordings cannot tell apart, likeliest first; the first predicts how
        the axis moves.
    effects : sequence of str
        Names of effects that were not excited; asked for where there is one hypothesis only.
    folder : Path or None
        Where `next.csv` is written; None writes nothing.

    Returns
    -------
    NextExperiment or None
        None where there is nothing to tell apart or to excite, or no reference that a drive could
        play.
    """
    reference = reference_input(case)
    if reference is None or (len(rivals) < 2 and not effects):
        return None
    entries, records = make_menu(case, rivals[0], reference)
    names = rival_names(rivals, {u.name for u in case.setting.uncertain})
    named = dict(zip(names, rivals, strict=True))
    with playing(case, records):
        choice = choose(case, entries, named, effects, _excited_by(case, rivals[0]))
    if choice is None:
        return None
    recording = joined(records, choice.plays, FILE_NAME)
    if choice.names and folder is not None:
        write_recording(recording, Path(folder) / FILE_NAME)
    file = FILE_NAME if choice.names else ""
    if choice.separation is None:
        why = f"{choice.motion}, {choice.why}" if choice.names else _silent(case, effects)
        return NextExperiment(file, choice.names, 0.0, 0.0, {}, why)
    vain = "" if choice.names else "no experiment on the menu separates them: the best, "
    points = {name: one.hypothesis.point(one.x) for name, one in named.items()}
    return NextExperiment(
        file,
        choice.names,
        choice.separation.worth[1],
        ENOUGH,
        predicted_outcomes(case, recording, points),
        f"{vain}{choice.motion}, {choice.why}",
    )


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


def _silent(case: Case, effects: Sequence[str]) -> str:
    why = "; ".join(
        f"{words(n)}: {CATALOGUE[n].not_excited(case.setting.excitation)}" for n in effects
    )
    return f"no reference within the recorded range and speed excites them: {why}"


def _excited_by(case: Case, base: Fitted) -> Size:
    """Size 1 of an effect that the recordings and a run together excite, where one excites it."""

    @cache
    def states() -> list[States | None]:
        runs = case.simulations.run([base.hypothesis.point(base.x)])[0]
        pairs = zip(runs, case.simulations.records, strict=True)
        return [states_of(run, record) if run.finite else None for run, record in pairs]

    def size(name: str, plays: Plays) -> float:
        moved = [one for place in plays if (one := states()[place]) is not None]
        excited = CATALOGUE[name].not_excited(_with(case.setting.excitation, moved)) is None
        return 1.0 if excited else math.inf

    return size


def _with(excitation: Excitation, moved: Sequence[States]) -> Excitation:
    """Excitation by the recordings and further motions together."""
    if not moved:
        return excitation
    durations = [float(states.time[-1] - states.time[0]) for states in moved]
    speeds = [float(np.quantile(np.abs(states.velocity), 0.995)) for states in moved]
    return replace(
        excitation,
        reversals=excitation.reversals + reversals(*moved),
        stroke=max(excitation.stroke, *(float(np.ptp(states.position)) for states in moved)),
        speed=max(excitation.speed, *speeds),
        duration=max(excitation.duration, sum(durations)),
        total=excitation.total + sum(durations),
    )
