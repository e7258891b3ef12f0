"""The loop: ask for gains, tell what came of them, or run it all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import InputError, NotTheGainsError
from gmfbo.interrupt import unwrapped_interrupt
from gmfbo.recordings.store.trial import Trial
from gmfbo.sources.plants.plant_call import PlantFunction
from gmfbo.sources.plants.recorded_grid import RecordedGrid
from gmfbo.sources.plants.source import Source
from gmfbo.tuning.drift_watch import DriftWatch
from gmfbo.tuning.history.history import History
from gmfbo.tuning.history.remarks import last_failure
from gmfbo.tuning.methods import find_method
from gmfbo.tuning.proposals import Proposals
from gmfbo.tuning.query.method import Method, Recommendation
from gmfbo.tuning.query.progress import Phase, ProgressCallback
from gmfbo.tuning.query.request import TrialRequest, TuningResult
from gmfbo.tuning.study import study_terms as terms
from gmfbo.tuning.study.noisy_axis import next_axis
from gmfbo.tuning.study.playing import play
from gmfbo.tuning.study.refusals import refuse_unplayable
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study.study_sources import StudySources
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.told.earlier_runs import EarlierRuns
from gmfbo.tuning.told.not_the_gains import log_not_the_gains
from gmfbo.tuning.told.real_axis import RealAxis, scorable
from gmfbo.tuning.told.recorded_choice import RecordedChoice
from gmfbo.tuning.told.told_gains import told_gains
from gmfbo.tuning.told.told_series import Told, read_told
from gmfbo.tuning.twin.closer_look import look_closer
from gmfbo.tuning.twin.twin_runs import TwinRuns
from gmfbo.tuning.twin_corrections import TwinCorrections
from gmfbo.tuning.watch import Watch

if TYPE_CHECKING:
    from gmfbo.recordings.store.memory_store import TrialStore


class Tuner:
    """Tunes the gains of a study; a context manager that holds the study's folder.

    Each proposal follows from the seed and the runs on disk alone: a study that was killed goes
    on exactly as if it had not been, and a run that was asked for but never told is asked for
    again with the same gains.

    Parameters
    ----------
    study : Study
        What `Study.read` returned for a study file or folder.
    is1, is2 : Source, optional
        Used instead of the sources that the file names.
    plant : callable, optional
        Is the real axis: called with gains and reference, it returns a `Recording`, the path of
        one, or arrays by name with `time`. What it raises is a failed run.
    method : Method, optional
        Used instead of the method that the file names.
    resume : bool
        Go on where a former tuner stopped; otherwise a study with trials is refused.
    store : TrialStore, optional
        Keeps the runs instead of the study's folder.

    Raises
    ------
    InputError
        The study, its twins or its folder cannot be used.
    """

    def __init__(
        self,
        study: Study,
        *,
        is1: Source | None = None,
        is2: Source | None = None,
        plant: PlantFunction | None = None,
        method: Method | None = None,
        resume: bool = True,
        store: TrialStore | None = None,
    ) -> None:
        self.study = study
        self.method = method or find_method(study.file.method)
        with ExitStack() as closing:
            self._sources = StudySources.open(
                study.file, study.origin, is1=is1, is2=is2, plant=plant
            )
            closing.callback(self._sources.close)
            self.gains = GainChoice.combine(
                self._sources.gains, study.file.gains, self._sources.parameters
            )
            if not study.begun:
                refuse_unplayable(study.file, self.gains, self._sources)
            own = terms.own_metrics(study)
            self.experiment = terms.experiment_of(study, self._sources.reference_unit, own)
            now = terms.in_force(study.file.gains, self.gains)
            starts = np.vstack([now, terms.known_safe(study.file.safety, self.gains)])
            terms.check_signals(study.file.safety, self._sources)
            real = self._sources.is1
            recorded = (
                RecordedChoice.within(real, self.gains) if isinstance(real, RecordedGrid) else None
            )
            self._earlier = EarlierRuns.find(study, self.gains, self.experiment)
            self._store: TrialStore = store or closing.enter_context(
                study.open_for_writing(resume=resume)
            )
            correction = self.method.correction
            self.history = History(
                self._store,
                study.file,
                self.experiment,
                self.gains,
                survey=correction.survey if correction else 0,
                earlier=len(self._earlier),
                ranked=terms.ranked(study, self._store, self.method),
                starts=starts,
                limited=self.study.objective_version(self._store) >= 2,
            )
            hashes = {"metrics": own.content_hash} if own else {}
            study.log_begin(self._store, self._sources.content_hashes | hashes)
            if len(self._earlier) and study.earlier_logged is None:
                self._store.log("earlier", **self._earlier.event)
            self._closing = closing.pop_all()
        self._prepare(starts, recorded)

    def _prepare(self, starts: NDArray[np.float64], recorded: RecordedChoice | None) -> None:
        """Set up what decides on queries, from the runs on disk."""
        study, correction = self.study, self.method.correction
        around_real = correction if correction and correction.around_real else None
        self._twin = TwinRuns(
            self._sources.is2,
            self.history,
            around_real,
            self._announce,
            lambda news: self._watch.say(news),
        )
        self._corrections = TwinCorrections.begin(self.method, self._twin)
        self._twin = self._corrections.runs
        self._closing.callback(self._corrections.close)
        self._pending = TrialRequest.unanswered(self._store.events(), self.history.next_number)
        self._last_request = self._pending
        self._drift = DriftWatch(self.history, study.file.drift)
        self._proposals = Proposals(
            self.method, self.history, self.gains, starts, recorded, self._drift, self._corrections
        )
        self._watch = Watch(self.history)

    def ask(self, fixed: Mapping[str, float] | None = None) -> TrialRequest | None:
        """Return the next real run that is wanted; twin runs that come before it are made here.

        Asking again before telling returns the same request.

        Parameters
        ----------
        fixed : mapping of str to float, optional
            Gains to be held at a value in this proposal.

        Returns
        -------
        TrialRequest or None
            None when the budget is used up, or the method has nothing more to ask.

        Raises
        ------
        InputError
            A fixed gain is unknown or outside its range.
        """
        held = dict(fixed or {})
        self.gains.check_fixed(held)
        while (request := self._next(held)) is not None and request.source == "IS2":
            trial = self._twin.query(request.gains)
            self._pending = None
            self._announce("query", trial)
        return request

    def tell(
        self,
        trial: TrialRequest | int,
        recording: Told | Sequence[Told],
        *,
        gains: Mapping[str, float] | None = None,
        anyway: bool = False,
    ) -> Trial:
        """Take the recording of the run that was asked for.

        Parameters
        ----------
        trial : TrialRequest or int
            What `ask` returned, or its number.
        recording : Recording, str or Path, or a sequence of them
            What was measured, or the file, whose columns are read as the twin file says; of
            several references one each. A `Trajectory` with a status other than `ok` is a failed
            run.
        gains : mapping of str to float, optional
            Gains in force, where they are other than asked for or than the recording says.
        anyway : bool
            Take a recording that was made at other gains than asked for, or told before.

        Returns
        -------
        Trial
            With its cost, on disk.

        Raises
        ------
        InputError
            The run was not asked for, or told already, or a gain is none; nothing is lost.
        RecordingError
            The recording was made at other gains, lacks the signal or is too short.
        """
        pending = self._awaited(trial)
        run = read_told(recording, self._sources.reading, self.experiment)
        if not anyway:
            run.refuse_repeated(self._store.events())
        used = told_gains(pending, run.recording, self.gains, given=gains, anyway=anyway)
        source = self._sources.real(self.history.made)
        twin = source.content_hash if source else ""
        judged = self.history.envelope.judge(run.recording)
        told = self.history.trial("IS1", used, judged, twin=twin)
        self.history.write(told)
        self._store.log("tell", number=pending.number, gains=used, file=run.file, sha256=run.sha256)
        self._pending = None
        initial = len(self.history.of("IS1")) <= self.study.file.budget.initial_is1
        self._announce("initial" if initial else "query", told)
        return told

    def not_the_gains(self, trial: TrialRequest | int, why: str) -> None:
        """Say that the requested run failed for another reason than its gains.

        Nothing is learned from it; `ask` returns the same request.

        Parameters
        ----------
        trial : TrialRequest or int
            What `ask` returned, or its number.
        why : str
            Reason, in a few words.

        Raises
        ------
        InputError
            The run was not asked for, or told already.
        SimulationError
            It is the third in a row.
        """
        log_not_the_gains(self._store, self._awaited(trial).number, why)

    def run(self, progress: ProgressCallback | None = None) -> TuningResult:
        """Run the study to the end of its budget.

        Parameters
        ----------
        progress : callable, optional
            Called with a `Progress` after each finished run.

        Returns
        -------
        TuningResult
            Best observed gains and, separately, the recommended ones.

        Raises
        ------
        InputError
            The real axis is not one that can be run from here.
        SimulationError
            No initial run of the twin succeeded, or three real runs in a row failed for another
            reason than their gains.
        """
        if self._sources.is1 is None:
            raise InputError(
                "[is1] ask_tell: somebody else runs this plant; use 'gmfbo ask' and 'gmfbo tell', "
                "Tuner.ask and Tuner.tell, or Tuner(study, plant=FUNCTION)"
            )
        self.watch(progress)
        try:
            with unwrapped_interrupt():
                while (request := self.ask()) is not None:
                    try:
                        run = play(
                            self._plant(), request.gains, self.experiment, self.history.envelope
                        )
                    except NotTheGainsError as error:
                        self.not_the_gains(request, str(error))
                        continue
                    self.tell(request, scorable(run, self.experiment))
        except KeyboardInterrupt:
            self._store.log("interrupt", trials=len(self.history.trials))
            raise
        result = self.result()
        self._announce("done", self.history.trials[-1])
        return result

    def watch(self, progress: ProgressCallback | None) -> None:
        """Report each finished run from now on.

        Parameters
        ----------
        progress : callable or None
            Called with a `Progress`.
        """
        self._watch = Watch(self.history, progress)

    def result(self) -> TuningResult:
        """Best and recommended gains as of now; the recommendation is also logged."""
        history, recommendation = self.history, None
        if history.settled or (history.of("IS1") and not history.ranked):
            method = self._proposals.method_in_force
            point, mean, std = method.recommend(history.state({}))
            gains = self.gains.values(self.gains.space.from_unit(point))
            recommendation = Recommendation(gains, mean, std)
            self._store.log("recommendation", gains=gains, mean=mean, std=std)
        self._store.refresh_index()
        return TuningResult(
            best=history.best,
            recommendation=recommendation,
            is1_runs=history.made,
            queries=history.queries,
            cost=history.cost,
            drifts=tuple(history.drifts),
            earlier=len(self._earlier),
            left_out=self._earlier.left_out,
            twin_versions=self._corrections.reasons,
            settled=history.settled or not history.ranked,
            remarks=history.remarks,
            last_failure=last_failure(history.of("IS1")),
        )

    @property
    def pending(self) -> TrialRequest | None:
        """Run that was asked for and not told yet."""
        return self._pending

    def close(self) -> None:
        """Give back twins and the folder; everything told is on disk already."""
        self._closing.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _awaited(self, trial: TrialRequest | int) -> TrialRequest:
        """The pending request, if it is this one."""
        number = trial if isinstance(trial, int) else trial.number
        pending = self._pending
        if pending is None or pending.number != number or pending.source != "IS1":
            wanted = f"trial {pending.number} is" if pending else "none is"
            raise InputError(
                f"trial {number} is not waited for: {wanted}; ask for the next gains first"
            )
        return pending

    def _next(self, held: Mapping[str, float]) -> TrialRequest | None:
        """Do what must precede the next query, and decide on it."""
        pending = self._pending
        if pending is not None and all(pending.gains[name] == held[name] for name in held):
            return pending
        self._twin.initial()
        self._twin.survey()
        self._take_earlier()
        self._twin.follow_up()
        if drift := self._drift.look():
            self._watch.tell("drift", self.history.of("IS1")[-1], None, drift.message)
        self._twin = self._corrections.follow(self._watch)
        self._watch.tell_used_up()
        if self._proposals.used_up:
            return None
        if not held:
            look_closer(self.method, self._twin)
        request = self._proposals.next(held)
        if request is None:
            return None
        self._store.log("ask", **asdict(request))
        self.history.note_asked(request.number, request.expected)
        self._pending = self._last_request = request
        return request

    def _take_earlier(self) -> None:
        """Take over the runs of an earlier study, each as a real run of this one; once."""
        for position in range(len(self.history.of("IS1")), len(self._earlier)):
            self._twin.follow_up()  # of the one before
            taken = self.history.taken_over(self._earlier.read(position))
            self._announce("initial", self.history.write(taken))

    def _plant(self) -> Source:
        recorded, played = self._proposals.recorded, self._proposals.played
        if recorded is not None:
            return RealAxis(recorded.grid.after(played))
        return RealAxis(next_axis(self._sources, self.study.file, len(played)))

    def _announce(self, phase: Phase, trial: Trial) -> None:
        self._watch.tell(phase, trial, self._last_request)
