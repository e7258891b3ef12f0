"""Runs of the twin that the tuning loop makes by itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from gmfbo.recordings.store.trial import Trial
from gmfbo.sources.plants.source import Source
from gmfbo.tuning.history.history import History
from gmfbo.tuning.history.incumbent import has_settled
from gmfbo.tuning.query.initial_design import Stream, initial_points
from gmfbo.tuning.query.method import CorrectionOptions
from gmfbo.tuning.query.progress import Phase
from gmfbo.tuning.study.playing import play
from gmfbo.tuning.twin.corrected_runs import CorrectedRuns
from gmfbo.tuning.twin.points_around import points_around

Announce = Callable[[Phase, Trial], None]

REPEATED_SHARE = 0.25
"""Share of the survey that a twin corrected again repeats: that of the least cost so far. The ranks
of a twin and its next version agree over the box (Spearman 0.7 to 0.9), so that the optimum of one
lies in the best quarter of the other."""

WORTH_A_LINE_S = 60.0
"""[s] Time of all twin runs from which it is said beforehand."""


@dataclass(frozen=True, eq=False)
class TwinRuns:
    """Initial runs of the twin, its queries, and its runs after a real run.

    Attributes
    ----------
    source : Source
        The twin.
    history : History
        The runs are added to it.
    correction : CorrectionOptions or None
        Options of the method's corrected runs.
    announce : callable
        Called with each finished run.
    say : callable
        Called with a sentence for the user.
    """

    source: Source
    history: History
    correction: CorrectionOptions | None
    announce: Announce
    say: Callable[[str], None] = lambda _: None

    def initial(self) -> None:
        """Run the initial points, shape (initial_is2, d).

        Their costs need constants from all of them, and a trial is written once and whole. So
        these runs go to disk together, when the last is done.

        Raises
        ------
        SimulationError
            All of them failed.
        """
        history = self.history
        if history.normalised:
            return
        count, seed = history.study.budget.initial_is2, history.study.seed
        points = initial_points(history.gains.space, seed, Stream.INITIAL_IS2, count)
        done = len(history.trials)
        runs = list(history.trials)
        for number, point in enumerate(points[done:], start=done + 1):
            runs.append(self._run(history.gains_at(point), number=number, with_margins=True))
            done_in = [run.seconds for run in runs if run.status == "ok"]
            if len(done_in) == 2 and runs[-1].status == "ok":
                self._tell_plan(min(done_in))  # the first also started the twin's process
        history.normalise(runs)
        constants, first = history.objective, runs[0].recording
        history.store.log(
            "normalise",
            mean=dict(constants.mean),
            std=dict(constants.std),
            worst=dict(constants.worst),
            units=history.units_of(first),
        )
        for run in runs[done:]:
            self.announce("initial", history.write(history.priced(run)))

    def _tell_plan(self, each: float) -> None:
        """Say beforehand how long a twin takes of which each run takes so long [s].

        Versions of the twin that the study may make are not foreseen: they repeat runs.
        """
        history, options = self.history, self.correction
        budget = history.study.budget
        looks = 2 * len(history.gains.space) * options.closer if options else 0
        beside = 1 + budget.is3_per_run + looks if options else 0
        real = budget.is1_runs or budget.initial_is1 + budget.most_queries
        count = budget.initial_is2 + history.survey + beside * real
        seconds = each * count
        if seconds > WORTH_A_LINE_S:
            took = f"{each:.2g}" if each < 9.5 else f"{each:.0f}"
            self.say(
                f"a twin run takes {took} s: {count} runs or more, "
                f"{seconds / 60.0:.0f} min; [budget] is2_runs or is2_seconds "
                f"(now {budget.is2_seconds:g}) end them earlier, and method 'bo_ei' makes "
                f"{budget.initial_is2} of them"
            )

    def survey(self) -> None:
        """Run the twin over the box, once, if the method asks for it; after a kill, the rest."""
        history = self.history
        points = initial_points(
            history.gains.space, history.study.seed, Stream.SURVEY, history.survey
        )
        done = len(history.unprompted) - history.study.budget.initial_is2
        for point in points[done:]:
            if history.twin_used_up:
                return
            trial = history.write(self._run(history.gains_at(point)))
            self.announce("initial", trial)

    def renew(self) -> None:
        """Repeat the twin's runs on the corrected twin; after a kill, make the rest.

        The first correction repeats the whole survey, a later one its best quarter.

        Runs around a real one are made for the last real run only: earlier ones served the
        queries before the correction.
        """
        history = self.history
        again = [t for t in history.of("IS2") if t.parent is None and history.is_current(t)]
        for gains in self._worth_repeating()[len(again) :]:
            self.announce("correction", history.write(self._run(gains)))
        for real in history.of("IS1"):
            self._beside(real)
        self.follow_up()

    def _worth_repeating(self) -> list[Mapping[str, float]]:
        """Gains of the survey for a corrected twin: all at first, later the best by their cost."""
        history, whole = self.history, self.history.unprompted
        if history.is_current(whole[0]):
            return [trial.gains for trial in whole]
        latest: dict[tuple[float, ...], Trial] = {}
        before = [t for t in history.of("IS2") if t.parent is None and not history.is_current(t)]
        for trial in before:
            latest[tuple(trial.gains.values())] = trial
        if len(before) == len(whole):
            return [trial.gains for trial in whole]
        ranked = sorted(latest.values(), key=lambda t: (not has_settled(t), t.objective))
        return [trial.gains for trial in ranked[: round(REPEATED_SHARE * len(whole))]]

    def query(self, gains: Mapping[str, float]) -> Trial:
        """Run the twin at the gains of a query."""
        return self.history.write(self._run(gains, with_margins=True))

    def follow_up(self) -> None:
        """Run the twin beside and around the newest real runs; some methods correct the latter.

        After a kill, only the missing runs are made.
        """
        if self.correction is None or self.history.twin_used_up:
            return
        corrected = CorrectedRuns(self.source, self.history, self.correction)
        for real in self.history.fresh:
            self._beside(real)
            if not self.correction.corrected:
                made = len(self.history.children(real, "IS2")) - 1  # the first lies beside
                for point in points_around(self.history, real)[made:]:
                    self.beside_again(real, self.history.gains_at(point))
                continue
            for trial in corrected.around(real):
                self.announce("correction", trial)

    def beside_again(self, real: Trial, gains: Mapping[str, float]) -> None:
        """Run the twin because of a real run, at other gains.

        Parameters
        ----------
        real : Trial
            The real run, with the twin's run at its gains in the history.
        gains : mapping of str to float
            All gains by name.
        """
        trial = self.history.write(self._run(gains, parent=real.number))
        self.announce("correction", trial)

    def _beside(self, real: Trial) -> None:
        """Run the twin at the gains of a real run, unless that was done."""
        if not self.history.children(real, "IS2"):
            pair = self._run(real.gains, parent=real.number)
            self.announce("correction", self.history.write(pair))

    def _run(
        self,
        gains: Mapping[str, float],
        *,
        parent: int | None = None,
        number: int | None = None,
        with_margins: bool = False,
    ) -> Trial:
        run = play(self.source, gains, self.history.experiment)
        return self.history.trial(
            "IS2",
            gains,
            run,
            twin=self.source.content_hash,
            parent=parent,
            number=number,
            with_margins=with_margins,
        )
