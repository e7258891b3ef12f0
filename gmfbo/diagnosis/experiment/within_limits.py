"""Choose the next experiment within limits, for the twin alone or to settle a diagnosis."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.checking.nominal_case import open_nominal
from gmfbo.diagnosis.checking.showable_sizes import Excited, showable_sizes
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.experiment.explained_twin import fitted_as_saved, points_of
from gmfbo.diagnosis.experiment.menu_runs import Menu, Played, play, playing
from gmfbo.diagnosis.experiment.outcome_words import predicted_outcome
from gmfbo.diagnosis.experiment.play_limits import PlayLimits
from gmfbo.diagnosis.experiment.play_patterns import play_patterns
from gmfbo.diagnosis.experiment.played_input import played_input
from gmfbo.diagnosis.experiment.proposal import ProposedExperiment
from gmfbo.diagnosis.experiment.reference_menu import MenuEntry
from gmfbo.diagnosis.experiment.safe_player import Peaks, SafePlayer
from gmfbo.diagnosis.experiment.separation import Plays, Separation, separations
from gmfbo.diagnosis.result.named_effect import DetectableSize
from gmfbo.diagnosis.result.predictions import PARAMETERS_ONLY, Explanation
from gmfbo.diagnosis.runs.scored_record import scored_record
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.errors import InputError, SimulationError
from gmfbo.plain_words import NOT_EXCITED
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.version import __version__

Progress = Callable[[str, float], None]
Pattern = tuple[MenuEntry, NDArray[np.float64]]

POSITION_NOISE, OTHER_NOISE = 1e-4, 2e-3
"""Assumed noise, as a share of a signal's range, without a diagnosis that measured it."""

_SUBSTEPS = 5  # substeps of a communication step while only limits are checked
_UNSEEN = 100.0  # times the smallest size: an effect that does not show counts as this large


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
    explanations = _explanations(diagnosis)
    points = [Point(), *(Point(e.parameters, e.physics) for e in explanations)]
    played = played_input(twin)
    with SafePlayer(twin, played, limits, _SUBSTEPS, points) as player:
        told("keeping the limits", 0.02)
        patterns = _playable(player, limits)
        records = [player.reference(column, entry.name) for entry, column in patterns]
        noisy = _as_recorded(twin, records, diagnosis, np.random.default_rng(seed))
        told("running the patterns", 0.1)
        case = open_nominal(twin, noisy, seed=seed, jobs=jobs, on_run=lambda: None).case
        try:
            choice = _Choice(case, [entry for entry, _ in patterns], diagnosis, explanations, told)
            column, peaks = _joined(player, limits, [patterns[place] for place in choice.best])
            told("predicting", 0.95)
            recording = player.reference(column, "next.csv")
            return choice.proposed(recording, limits, peaks)
        finally:
            case.simulations.close()


def _explanations(diagnosis: Diagnosis | None) -> tuple[Explanation, ...]:
    if diagnosis is None:
        return ()
    if diagnosis.predictions is None:
        raise InputError(
            "expected a diagnosis that holds 'predictions', which this older one does not; "
            "diagnose again"
        )
    return diagnosis.predictions.explanations


def _joined(
    player: SafePlayer, limits: PlayLimits, patterns: Sequence[Pattern]
) -> tuple[NDArray[np.float64], Peaks]:
    """Column that plays patterns one after the other, within the limits, and its peaks."""
    motion = np.concatenate([entry.values for entry, _ in patterns])
    column = np.concatenate([played for _, played in patterns])
    peaks = player.peaks(motion, column)
    if peaks.excess(limits, float(motion[0])) > 1.0:
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


class _Choice:
    """Chooses two patterns, and gathers what they show."""

    def __init__(
        self,
        case: Case,
        entries: Sequence[MenuEntry],
        diagnosis: Diagnosis | None,
        explanations: Sequence[Explanation],
        progress: Progress,
    ) -> None:
        self.case, self.entries, self.explanations = case, tuple(entries), tuple(explanations)
        self.progress = progress
        named = [e for e in explanations if e.name != PARAMETERS_ONLY]
        self.rivals = tuple(named) if len(named) > 1 else ()
        self.excited = showable_sizes(
            case, lambda share: progress("screening the library", 0.2 + 0.6 * share)
        )
        self.wanted = _wanted(diagnosis, self.excited)
        self.separation: Separation | None = None
        pairs = list(combinations_with_replacement(range(len(self.entries)), 2))
        if self.rivals:
            progress("playing the rivals", 0.82)
            self.separation = max(self._separations(pairs), key=lambda one: one.worth())
            self.best: Plays = self.separation.plays
        else:
            self.best = min(pairs, key=self._badness)

    @property
    def words(self) -> str:
        first, second = (self.entries[place].words for place in self.best)
        return f"{first}, played twice" if first == second else f"{first}, then {second}"

    def proposed(
        self, recording: Recording, limits: PlayLimits, peaks: Peaks
    ) -> ProposedExperiment:
        sizes = {name: self._size(name, self.best) for name in self.excited.showable}
        shows = {
            name: DetectableSize(
                self.excited.showable[name].parameter, size, self.excited.showable[name].unit
            )
            for name, size in sizes.items()
            if math.isfinite(size)
        }
        return ProposedExperiment(
            recording=recording,
            words=self.words,
            limits=limits,
            peaks=peaks,
            shows=shows,
            hidden=self.excited.not_testable,
            wanted=tuple(name for name in self.wanted if name in shows),
            separation=self.separation,
            predicted=self._predicted(recording),
        )

    # ---- what it shows -----------------------------------------------------------------------

    def _size(self, name: str, pair: Plays) -> float:
        """Smallest size that two patterns show: what each tells adds up."""
        seen = self.excited.showable[name]
        records = self.case.simulations.records
        alone = [seen.alone.get(records[place].name, math.inf) for place in pair]
        told = sum(size**-2.0 for size in alone if math.isfinite(size) and size > 0.0)
        return max(told**-0.5, seen.floor) if told > 0.0 else math.inf

    def _badness(self, pair: Plays) -> float:
        """Mean logarithm of the sizes, each relative to the smallest that any two would show."""
        names = self.wanted or tuple(self.excited.showable)
        total = 0.0
        for name in names:
            least = min(
                self._size(name, other)
                for other in combinations_with_replacement(range(len(self.entries)), 2)
            )
            size = self._size(name, pair)
            if math.isfinite(least):
                total += math.log(min(size / least, _UNSEEN))
        return total

    # ---- what tells rivals apart -------------------------------------------------------------

    def _separations(self, pairs: Sequence[Plays]) -> list[Separation]:
        """What each two patterns tell of the rivals."""
        case = self.case
        runs = {}
        for rival in self.rivals:
            done = play(case, fitted_as_saved(rival, case.setting, case.twin))
            if done is not None:
                runs[rival.name] = done
        if len(runs) < 2:
            raise SimulationError(
                f"{case.twin.name}: the twin cannot follow the patterns under the rivals"
            )
        return separations(case, Menu(self.entries, (), case.simulations.records), runs, pairs)

    def _predicted(self, recording: Recording) -> dict[str, str]:
        """Predicted outcome under each explanation; empty where there is only one."""
        case = self.case
        shown = self.rivals or self.explanations
        if len(shown) < 2:
            return {}
        like = case.simulations.records[0]
        with AugmentedTwin(case.twin, substeps=case.substeps) as simulator:
            plan = simulator.plan(recording, {})
        columns = {s.name: np.zeros(recording.time.size) for s in like.signals}
        made = replace(recording, signals={**recording.signals, **columns})
        record = scored_record(made, plan, list(columns), 0.0)
        points = points_of(shown, case.setting, case.twin)
        with playing(case, Menu((), (), (record,))):
            runs = case.simulations.run(list(points.values()))
        played = {
            name: Played(list(run), [])
            for name, run in zip(points, runs, strict=True)
            if all(one.finite for one in run)
        }
        if len(played) < 2:
            return {}
        return {name: predicted_outcome(case, record, name, 0, played) for name in played}


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
