"""Choose the next experiment within limits, for the twin alone or to settle a diagnosis."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.checking.nominal_case import open_nominal
from gmfbo.diagnosis.checking.showable_sizes import Excited, showable_sizes
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.experiment.choice import Size, choose
from gmfbo.diagnosis.experiment.explained_twin import fitted_as_saved, points_of, saved_predictions
from gmfbo.diagnosis.experiment.outcome_words import predicted_outcomes
from gmfbo.diagnosis.experiment.play_limits import PlayLimits
from gmfbo.diagnosis.experiment.play_patterns import play_patterns
from gmfbo.diagnosis.experiment.played_input import played_input
from gmfbo.diagnosis.experiment.proposal import ProposedExperiment
from gmfbo.diagnosis.experiment.reference_menu import MenuEntry
from gmfbo.diagnosis.experiment.safe_player import Peaks, SafePlayer
from gmfbo.diagnosis.experiment.separation import Plays
from gmfbo.diagnosis.result.named_effect import DetectableSize
from gmfbo.diagnosis.result.predictions import PARAMETERS_ONLY
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.errors import InputError, SimulationError
from gmfbo.plain_words import NOT_EXCITED
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.version import __version__

Progress = Callable[[str, float], None]
Pattern = tuple[MenuEntry, NDArray[np.float64]]

POSITION_NOISE, OTHER_NOISE = 1e-4, 2e-3
"""Assumed noise, as a share of a signal's range, without a diagnosis that measured it."""

_SUBSTEPS = 5  # substeps of a communication step while only limits are checked
_MOST_EFFECTS = "shows, of the menu, most effects at the smallest sizes"


def propose_experiment(
    twin: FmuTwin,
    limits: PlayLimits,
    diagnosis: Diagnosis | None = None,
    *,
    seed: int = 0,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> ProposedExperiment:
    """Choose the next experiment: two patterns of the menu, one after the other.

    Without a diagnosis, the patterns show most effects at the smallest sizes. A diagnosis with
    rivals asks for patterns on which the refitted rivals differ most; a diagnosis without rivals
    for patterns that best excite the effects not excited so far.

    Parameters
    ----------
    twin : FmuTwin
        The twin.
    limits : PlayLimits
        Of the axis.
    diagnosis : Diagnosis, optional
        Of earlier recordings.
    seed : int
        Of the noise.
    jobs : int, optional
        Simulations at a time; one a processor unless given.
    progress : callable (str, float), optional
        Called with the stage and the share done.

    Raises
    ------
    InputError
        No reference keeps the limits, or the diagnosis is of another twin.
    SimulationError
        The twin cannot follow what would be played.
    """
    told = progress or (lambda stage, share: None)
    explanations = () if diagnosis is None else saved_predictions(diagnosis).explanations
    points = [Point(), *(Point(e.parameters, e.physics) for e in explanations)]
    played = played_input(twin)
    with SafePlayer(twin, played, limits, _SUBSTEPS, points) as player:
        told("keeping the limits", 0.02)
        patterns = _playable(player, limits)
        references = [player.reference(column, entry.name) for entry, column in patterns]
        noisy = _as_recorded(twin, references, diagnosis, np.random.default_rng(seed))
        told("running the patterns", 0.1)
        case = open_nominal(twin, noisy, seed=seed, jobs=jobs, on_run=lambda: None).case
        try:
            return _proposed(case, patterns, player, diagnosis, told)
        finally:
            case.simulations.close()


def _proposed(
    case: Case,
    patterns: Sequence[Pattern],
    player: SafePlayer,
    diagnosis: Diagnosis | None,
    told: Progress,
) -> ProposedExperiment:
    twin = case.twin
    explanations = () if diagnosis is None else saved_predictions(diagnosis).explanations
    excited = showable_sizes(case, lambda share: told("screening the library", 0.2 + 0.6 * share))
    wanted = _wanted(diagnosis, excited)
    named = [e for e in explanations if e.name != PARAMETERS_ONLY]
    rivals = named if len(named) > 1 else []
    told("choosing the patterns", 0.82)
    entries = [entry for entry, _ in patterns]
    fits = {e.name: fitted_as_saved(e, case.setting, twin) for e in rivals}
    size = _shown_by(excited, [record.name for record in case.simulations.records])
    choice = choose(case, entries, fits, wanted or tuple(excited.showable), size)
    if choice is None:
        raise SimulationError(f"{twin.name}: the twin cannot follow the patterns under the rivals")
    column, peaks = _joined(player, [patterns[place] for place in choice.plays])
    told("predicting", 0.95)
    recording = player.reference(column, "next.csv")
    sizes = {name: size(name, choice.plays) for name in excited.showable}
    shows = {
        name: DetectableSize(excited.showable[name].parameter, least, excited.showable[name].unit)
        for name, least in sizes.items()
        if math.isfinite(least)
    }
    points = points_of(rivals or explanations, case.setting, twin)
    return ProposedExperiment(
        recording=recording,
        words=choice.motion,
        why=choice.why if rivals or (wanted and choice.shown) else _MOST_EFFECTS,
        limits=player.limits,
        peaks=peaks,
        shows=shows,
        hidden=excited.not_testable,
        wanted=tuple(name for name in wanted if name in shows),
        separation=choice.separation,
        predicted=predicted_outcomes(case, recording, points) if len(points) > 1 else {},
    )


def _shown_by(excited: Excited, patterns: Sequence[str]) -> Size:
    """Smallest size that a run shows: what each of its patterns tells adds up."""

    def size(name: str, plays: Plays) -> float:
        seen = excited.showable[name]
        alone = [seen.alone.get(patterns[place], math.inf) for place in plays]
        told = sum(own**-2.0 for own in alone if math.isfinite(own) and own > 0.0)
        return max(told**-0.5, seen.floor) if told > 0.0 else math.inf

    return size


def _joined(player: SafePlayer, patterns: Sequence[Pattern]) -> tuple[NDArray[np.float64], Peaks]:
    """Column that plays patterns one after the other, within the limits, and its peaks."""
    motion = np.concatenate([entry.values for entry, _ in patterns])
    column = np.concatenate([played for _, played in patterns])
    peaks = player.peaks(motion, column)
    if peaks.excess(player.limits, float(motion[0])) > 1.0:
        # One after the other they go a little further than each by itself.
        _, column, peaks, _ = player.shrunk(motion)
    return column, peaks


def _playable(player: SafePlayer, limits: PlayLimits) -> list[Pattern]:
    """Patterns shrunk until the axis keeps its limits, with the columns to play."""
    start = player.start
    if not limits.low <= start <= limits.high:
        raise InputError(
            f"{player.twin.name} stands at {start:g} and the limits of the position are "
            f"{limits.low:g} to {limits.high:g}; widen them, or let the twin start within"
        )
    found: list[Pattern] = []
    why: InputError | None = None
    for entry in play_patterns(limits, start, player.spacing):
        try:
            motion, column, _, _ = player.shrunk(entry.values)
        except InputError as error:
            why = error
            continue
        found.append((replace(entry, values=motion), column))
    if not found:
        assert why is not None, "there is at least one pattern"
        raise why
    return found


def _as_recorded(
    twin: FmuTwin,
    references: Sequence[Recording],
    diagnosis: Diagnosis | None,
    rng: np.random.Generator,
) -> list[Recording]:
    """The patterns as a logger would record them, with noise, if the axis were its twin."""
    told = None if diagnosis is None else diagnosis.predictions
    known = {} if told is None else told.noise
    recordings = []
    for reference in references:
        run = twin.run({}, reference)
        if run.status != "ok":
            raise SimulationError(f"{twin.name}: cannot follow {reference.name}: {run.message}")
        signals = dict(run.signals)
        for name in twin.file.outputs:
            share = POSITION_NOISE if run.units.get(name) in ("rad", "m") else OTHER_NOISE
            size = known.get(name, math.nan)
            size = size if math.isfinite(size) else share * float(np.ptp(signals[name]))
            signals[name] = signals[name] + size * rng.standard_normal(run.time.size)
        recordings.append(
            Recording(
                time=run.time,
                signals=signals,
                units=run.units,
                name=reference.name,
                written_by=__version__,
            )
        )
    return recordings


def _wanted(diagnosis: Diagnosis | None, excited: Excited) -> tuple[str, ...]:
    """Effects that a diagnosis could not test for want of motion, and that this might show."""
    if diagnosis is None:
        return ()
    silent: Collection[str] = {
        entry.name
        for entry in diagnosis.not_testable
        if entry.why.startswith((NOT_EXCITED, "changes nothing"))
    }
    return tuple(name for name in excited.showable if name in silent)
