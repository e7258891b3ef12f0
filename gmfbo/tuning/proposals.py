"""What is queried next: initial points, then repeats that are due, then the method's proposals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import ExhaustedError
from gmfbo.objective.limits import Limits
from gmfbo.plain_words import words
from gmfbo.sources.plants.plant_command import CommandPlant
from gmfbo.space import same_gain
from gmfbo.tuning.drift_watch import DriftWatch, Repeat
from gmfbo.tuning.history.history import History
from gmfbo.tuning.history.move_limit import LIMIT_TOLD
from gmfbo.tuning.history.remarks import WORTH, not_worth
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.history.worth import CONFIRMATIONS, expected_gain, noise_of_one_run
from gmfbo.tuning.methods import METHODS
from gmfbo.tuning.query.initial_design import Stream, initial_points, stream
from gmfbo.tuning.query.method import Method, Recommendation
from gmfbo.tuning.query.request import TrialRequest
from gmfbo.tuning.study.noisy_axis import next_axis
from gmfbo.tuning.study.study_sources import StudySources
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.told.real_axis import RealAxis
from gmfbo.tuning.told.recorded_choice import RecordedChoice
from gmfbo.tuning.twin.believed_twins import BelievedTwins
from gmfbo.tuning.twin_corrections import TwinCorrections

MOST_LISTED = 10_000
"""Points of a box of single values that are listed to find one that was not run."""


@dataclass(frozen=True, eq=False)
class Proposals:
    """Decides on each query of a study; every decision follows from the seed and the history.

    Attributes
    ----------
    method : Method
        Of the study.
    history : History
        All runs so far.
    gains : GainChoice
        Tuned and held gains.
    starts : ndarray, shape (n, d)
        Known-safe gains in the unit cube, which are run first.
    recorded : RecordedChoice or None
        Gains that may be asked for where the real runs are recordings.
    drift : DriftWatch
        Says which run is due to be repeated.
    corrections : TwinCorrections
        Versions of the twin.
    confirms : bool
        Whether the last runs may repeat the recommended gains.
    """

    method: Method
    history: History
    gains: GainChoice
    starts: NDArray[np.float64]
    recorded: RecordedChoice | None
    drift: DriftWatch
    corrections: TwinCorrections
    confirms: bool = False

    @property
    def played(self) -> list[Mapping[str, float]]:
        """Gains of the real runs, without those of an earlier study."""
        return [trial.gains for trial in self.history.of("IS1")[self.history.earlier :]]

    @property
    def asked(self) -> list[Mapping[str, float]]:
        """As `played`, with the gains that are waited for."""
        return [*self.played, *self.history.waiting.values()]

    @property
    def used_up(self) -> bool:
        """Whether the budget is spent, or every recording replayed."""
        recorded, size = self.recorded, self.gains.space.size
        return (
            self.history.used_up
            or (recorded is not None and recorded.used_up(self.asked))
            or (size is not None and len(self._run_since_change()) >= size)
        )

    def next(self, held: Mapping[str, float]) -> TrialRequest | None:
        """Decide on the next query; None where the method has nothing more to ask.

        Raises
        ------
        InputError
            No recording is left at the held values.
        """
        request = self._propose(held)
        if request is None or self.recorded is None or request.source != "IS1":
            return request
        proposed = self.history.unit_point(request.gains)
        nearest = self.recorded.nearest(proposed, self.asked, held)
        return replace(request, gains=nearest)

    def recommended(self) -> Recommendation | None:
        """Gains to take as of now; None while no real run settled."""
        history = self.history
        if not history.settled and (history.ranked or not history.of("IS1")):
            return None
        point, mean, std = self.method_in_force.recommend(history.state({}))
        return Recommendation(self.gains.values(self.gains.space.from_unit(point)), mean, std)

    def axis(self, sources: StudySources) -> RealAxis:
        """What plays the next real run.

        Parameters
        ----------
        sources : StudySources
            With a real axis that can be run from here.
        """
        played = self.played
        if self.recorded is not None:
            return RealAxis(self.recorded.grid.after(played))
        plant = next_axis(sources, self.history.study, len(played))
        if isinstance(plant, CommandPlant):
            plant = replace(plant, envelope=self.history.envelope, safe_gains=self._safe_gains())
        return RealAxis(plant)

    def _safe_gains(self) -> Mapping[str, float]:
        """Gains of the last run inside the envelope, or those in force; empty without either."""
        if self._inside:
            return self._inside[-1]
        return self.history.gains_at(self.starts[0]) if len(self.starts) else {}

    def _propose(self, held: Mapping[str, float]) -> TrialRequest | None:
        state, number = self._state(held), self.history.next_number
        seed, budget = self.history.study.seed, self.history.study.budget
        real = len(self.history.of("IS1")) + len(self.history.waiting)
        if len(held) == len(self.gains.space):
            wished = self.gains.values(self.gains.space.point(held))
            return self._doubts_told(TrialRequest(number, "IS1", wished), state)
        # While nothing is told, a method has nothing to learn from.
        if real < max(budget.initial_is1, len(self.starts)) or not self.history.of("IS1"):
            return self._first(real, state)
        repeat = None if self.recorded or held else self._repeat(state)
        if repeat is not None:
            return TrialRequest(number, "IS1", repeat.gains, None, repeat.why)
        try:
            proposal = self.method_in_force.propose(state, stream(seed, Stream.PROPOSAL, number))
        except ExhaustedError:
            return None
        if proposal is None:
            return None
        gains, note = self.history.gains_at(proposal.point), proposal.note
        expected = None if state.unsettled else proposal.expected
        if proposal.source == "IS1":
            allowed = self._allowed(state, proposal.point)
            if allowed != gains:
                expected = None
                note = f"{note} moved to gains that may be run".lstrip()
            gains = self._not_run_yet(state, allowed)
        asked = TrialRequest(number, proposal.source, gains, proposal.mismatch, note, expected)
        return self._within_margins(self._checked(self._weighed(asked, state), state))

    def _first(self, real: int, state: TuningState) -> TrialRequest:
        """One of the first runs; `real` runs were asked for before."""
        number, planned = self.history.next_number, self._first_points(real + 1)
        point = state.hold(planned[real])
        if real < len(self.starts) and np.array_equal(point, planned[real]):
            # The user vouches for these, whatever the twin says, and wherever others wait.
            return TrialRequest(number, "IS1", self.history.gains_at(point))
        gains = self._allowed(state, point)
        if real >= self.history.study.budget.initial_is1:
            gains = self._not_run_yet(state, gains)
        return self._checked(TrialRequest(number, "IS1", gains), state)

    def _first_points(self, count: int) -> NDArray[np.float64]:
        """Known-safe gains and Latin hypercubes, at least `count` points, shape (n, d)."""
        study, space = self.history.study, self.gains.space
        many = study.budget.initial_is1
        points = initial_points(space, study.seed, Stream.INITIAL_IS1, many)
        # Gains that are known to be safe replace the first of the Latin hypercube.
        points = np.vstack([self.starts, points[len(self.starts) :]])
        further = 0
        while len(points) < count:
            further += 1
            more = initial_points(space, study.seed, Stream.INITIAL_IS1, many, further)
            points = np.vstack([points, more])
        return points

    def _weighed(self, asked: TrialRequest, state: TuningState) -> TrialRequest:
        """The request with a note where it hardly promises a gain; of the last runs a repetition.

        It hardly promises one where the expected gain is below the noise of one run.
        """
        ranked = self.confirms and self.history.ranked
        if not ranked or asked.source != "IS1" or asked.expected is None:
            return asked
        noise = noise_of_one_run(state)
        # The luckiest run is no worse than the recommended gains, and needs no model.
        if expected_gain(asked.expected, state.incumbent()) >= noise:
            return asked
        point, mean, std = self.method_in_force.recommend(state)
        gain = expected_gain(asked.expected, mean)
        if gain >= noise:
            return asked
        history, note = self.history, not_worth(gain, noise)
        left = history.study.budget.queries_left(history.queries, history.made)
        last = left - len(history.waiting) <= CONFIRMATIONS
        confirms = last and self.recorded is None and not state.fixed
        history.store.log(WORTH, number=asked.number, gain=gain, noise=noise, confirms=confirms)
        if not confirms:
            return replace(asked, note=f"{asked.note} {note}: you may stop here".lstrip())
        gains, note = history.gains_at(point), f"{note}: repeats the recommended gains"
        return replace(asked, gains=gains, note=note, expected=(mean, std))

    @property
    def method_in_force(self) -> Method:
        """The study's method; expected improvement on real runs once the twin may not run."""
        return METHODS["bo_ei"] if self.history.twin_used_up else self.method

    def _within_margins(self, asked: TrialRequest) -> TrialRequest:
        """The request; where margins of the loop are beyond a limit, the twin runs it instead."""
        if asked.source != "IS1":
            return asked
        found, limits = self.history.margins.at(asked.gains), self.history.limits.stated
        limited = Limits({name: value for name, value in limits.items() if name in found})
        if limited.met(found):
            return asked
        told = [
            f"{words(name)} {found[name]:.3g}, limit {limit:g}"
            for name, limit in limited.stated.items()
        ]
        note = f"not run on the axis: {'; '.join(told)} (from the twin)"
        return replace(asked, source="IS2", note=note, expected=None)

    @property
    def _believed(self) -> BelievedTwins | None:
        """Twins that proposals are tried on; None without an envelope or a twin that may run."""
        history = self.history
        if not (history.envelope and history.ranked):
            return None
        if self.recorded is not None or history.twin_used_up:
            return None
        return BelievedTwins(self.corrections.runs.source, history)

    def _checked(self, asked: TrialRequest, state: TuningState) -> TrialRequest:
        """The request, or another where the twin, as uncertain as it is, leaves the envelope."""
        twins = self._believed
        if asked.source != "IS1":
            return asked
        doubted = None if twins is None else twins.doubt(asked.gains, state, asked.number)
        if doubted is None:
            return self._limits_told(asked, state)
        note = f"{asked.note} {doubted.note}".lstrip()
        if not doubted.withheld:
            return self._limits_told(replace(asked, note=note), state)
        self.history.store.log(
            "withheld", number=asked.number, gains=dict(asked.gains), leaving=doubted.leaving
        )
        asked = replace(asked, gains=dict(doubted.gains), note=note, expected=None)
        return self._limits_told(asked, state)

    def _doubts_told(self, asked: TrialRequest, state: TuningState) -> TrialRequest:
        """The request for gains that are all held, with a note on what the twin thinks of them."""
        twins = self._believed
        if twins is None or self._stayed_inside(asked.gains):
            return self._limits_told(asked, state)
        note = twins.leaving_note(asked.gains, asked.number)
        return self._limits_told(replace(asked, note=note), state)

    def _limits_told(self, asked: TrialRequest, state: TuningState) -> TrialRequest:
        """The request, with a note where held gains pass a limit that proposals keep to."""
        if not state.fixed or self._stayed_inside(asked.gains):
            return asked
        keep_out, point = self.history.keep_out(), self.history.unit_point(asked.gains)[None, :]
        notes = [asked.note] if asked.note else []
        if keep_out.moves is not None and not keep_out.moves.admits(point)[0]:
            notes.append(f"the held gains exceed the step limit, {LIMIT_TOLD}")
        if not replace(keep_out, moves=None).admits(point)[0]:
            notes.append("the held gains lie beside some at which axis or twin left the envelope")
        return replace(asked, note="; ".join(notes))

    def _stayed_inside(self, gains: Mapping[str, float]) -> bool:
        """Whether a real run at these gains ended well, inside the envelope."""
        inside = self._inside
        return any(all(same_gain(one[name], gains[name]) for name in gains) for one in inside)

    @property
    def _inside(self) -> list[Mapping[str, float]]:
        """Gains of the real runs that ended well, inside the envelope; a row of a table says no."""
        real = self.history.of("IS1")
        return [trial.gains for trial in real if trial.status == "ok" and not trial.bare]

    def _state(self, held: Mapping[str, float]) -> TuningState:
        """State from which the next query is chosen.

        What runs already at a bench is not asked for again: gains that are waited for are kept
        out with their neighbourhood, as around unsafe ones (local penalisation, Gonzalez et al.
        2016).
        """
        state, waiting = self.history.state(held), self.history.waiting
        if not waiting:
            return state
        points = np.stack([self.history.unit_point(gains) for gains in waiting.values()])
        width = len(self.gains.space)
        unsafe = np.vstack([np.reshape(state.keep_out.unsafe, (-1, width)), points])
        return replace(state, keep_out=replace(state.keep_out, unsafe=unsafe))

    def _run_since_change(self) -> set[tuple[float, ...]]:
        """Gains of the real runs since the plant changed, and of those that are waited for."""
        history = self.history
        since = [one.gains for one in history.of("IS1") if one.number > history.changed_after]
        return {tuple(self.gains.point(gains)) for gains in (*since, *history.waiting.values())}

    def _not_run_yet(self, state: TuningState, gains: dict[str, float]) -> dict[str, float]:
        """These gains, or of a box of few single values the nearest that were not run."""
        space, run = self.gains.space, self._run_since_change()
        point = self.gains.point(gains)
        size = space.size
        if size is None or size > MOST_LISTED or tuple(point) not in run:
            return gains
        left = np.array([one for one in space.grid() if tuple(one) not in run])
        unit = space.to_unit(left)
        unit = unit[np.all(np.isclose(unit, state.hold(unit)), axis=1)]
        unit = unit[state.keep_out.admitted(unit)]
        if not len(unit):
            return gains
        nearest = int(np.argmin(np.linalg.norm(unit - space.to_unit(point), axis=1)))
        return self.history.gains_at(unit[nearest])

    def _repeat(self, state: TuningState) -> Repeat | None:
        """Gains that are to be run again next; usually None.

        After a change, a twin just estimated from the runs since predicts the cost at the former
        best gains, so these are not repeated.
        """
        former = None if self.corrections.just_made else self.drift.former_best(state)
        return former or self.drift.regular(state)

    def _allowed(self, state: TuningState, point: NDArray[np.float64]) -> dict[str, float]:
        """Gains at a point, or the nearest that are not beside unsafe ones; for all methods."""
        space = self.gains.space
        nearest = state.keep_out.nearest_admitted(
            point, state.fixed_unit, lambda points: space.to_unit(space.from_unit(points))
        )
        return self.history.gains_at(nearest)
