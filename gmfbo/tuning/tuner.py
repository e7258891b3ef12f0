"""The loop: ask for gains, tell what came of them, or run it all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from typing import TYPE_CHECKING, Self, overload

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
from gmfbo.tuning.history.standing import StandingStore
from gmfbo.tuning.methods import find_method
from gmfbo.tuning.proposals import Proposals
from gmfbo.tuning.query.method import Method
from gmfbo.tuning.query.progress import Phase, ProgressCallback
from gmfbo.tuning.query.request import TrialRequest, TuningResult
from gmfbo.tuning.study import study_terms as terms
from gmfbo.tuning.study.playing import play
from gmfbo.tuning.study.refusals import refuse_unplayable
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study.study_sources import StudySources
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.told.earlier_runs import EarlierRuns
from gmfbo.tuning.told.not_the_gains import log_not_the_gains
from gmfbo.tuning.told.real_axis import scorable
from gmfbo.tuning.told.recorded_choice import RecordedChoice
from gmfbo.tuning.told.told_gains import chosen_request, told_gains
from gmfbo.tuning.told.told_series import Told, read_told
from gmfbo.tuning.told.waiting import Waiting
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
            self.experiment = terms.experiment_of(study, self._sources, own)
            starts = terms.starts_of(study.file, self.gains)
            terms.check_signals(study.file.safety, self._sources)
            real, recorded = self._sources.is1, None
            if isinstance(real, RecordedGrid):
                recorded = RecordedChoice.within(real, self.gains)
            own_part = (self.gains, self.experiment, self._sources)
            self._earlier = EarlierRuns.find(study, *own_part)
            opened = store or closing.enter_context(study.open_for_writing(resume=resume))
            self._store = StandingStore(opened)
            correction = self.method.correction
            self.history = History(
                self._store,
                study.file,
                self.experiment,
                self.gains,
                survey=correction.survey if correction else 0,
                earlier=len(self._earlier),
                meter=terms.margin_meter(study, self._sources, self.experiment),
                ranked=terms.ranked(study, self._store, self.method),
                starts=starts,
                limited=self.study.objective_version(self._store) >= 2,
            )
            hashes = self._sources.content_hashes | ({"metrics": own.content_hash} if own else {})
            study.log_begin(self._store, hashes, self._sources.told_of(self.gains))
            self._earlier.log_once(study, self._store)
            self._closing = closing.pop_all()
        self._prepare(starts, recorded)

    def _prepare(self, starts: NDArray[np.float64], recorded: RecordedChoice | None) -> None:
        """Set up what decides on queries, from the runs on disk."""
        options = terms.twin_options(self.study, self._store, self.method)
        self._watch = Watch(self.history)
        self._twin = TwinRuns(
            self._sources.is2, self.history, options, self._announce, lambda s: self._watch.say(s)
        )
        self._corrections = TwinCorrections.begin(self.method, self._twin)
        self._twin = self._corrections.runs
        self._closing.callback(self._corrections.close)
        self._waiting = Waiting(self.history)
        self._drift = DriftWatch(self.history, self.study.file.drift)
        self._proposals = Proposals(
            *(self.method, self.history, self.gains, starts, recorded, self._drift),
            *(self._corrections, self.study.objective_version(self._store) >= 3),
        )

    @overload
    def ask(self, fixed: Mapping[str, float] | None = None) -> TrialRequest | None: ...

    @overload
    def ask(
        self, fixed: Mapping[str, float] | None = None, *, parallel: int
    ) -> list[TrialRequest]: ...

    def ask(
        self, fixed: Mapping[str, float] | None = None, *, parallel: int | None = None
    ) -> TrialRequest | list[TrialRequest] | None:
        """Return the next real run that is wanted; twin runs that come before it are made here.

        Asking again before telling returns the same requests.

        Parameters
        ----------
        fixed : mapping of str to float, optional
            Gains to be held at a value in this proposal.
        parallel : int, optional
            Real runs to be asked for at once; those waited for count.

        Returns
        -------
        TrialRequest, list of TrialRequest, or None
            A list with `parallel`; None, or a shorter list, when there is nothing more to ask.

        Raises
        ------
        InputError
            A fixed gain is unknown or outside its range.
        """
        held, wanted = dict(fixed or {}), 1 if parallel is None else parallel
        self.gains.check_fixed(held)
        if wanted < 1:
            raise InputError(f"parallel: expected at least 1 run at once, got {wanted}")
        waiting = self._waiting.at(held)
        if not waiting and parallel is None and len(self._waiting.real) == 1:
            self._waiting.answered(*self._waiting.real)  # asked for anew, with other gains held
        while len(waiting) < wanted and (request := self._next(held)) is not None:
            if request.source == "IS1":
                waiting.append(request)
                continue
            trial = self._twin.query(request.gains)
            self._waiting.twin = None
            self._announce("query", trial)
        self._waiting.over = not waiting
        return waiting if parallel is not None else next(iter(waiting), None)

    def tell(
        self,
        trial: TrialRequest | int | None,
        recording: Told | Sequence[Told],
        *,
        gains: Mapping[str, float] | None = None,
        anyway: bool = False,
    ) -> Trial:
        """Take the recording of the run that was asked for.

        Parameters
        ----------
        trial : TrialRequest, int or None
            What `ask` returned, or its number. With None the run that is waited for; of several
            the one whose gains the recording states.
        recording : Recording, str or Path, or a sequence of them
            What was measured, or the file, whose columns are read as the twin file says; of
            several references one each. A `Trajectory` with a status other than `ok` is a failed
            run.
        gains : mapping of str to float, optional
            Gains in force, where they are other than asked for or than the recording says.
        anyway : bool
            Take a recording that contradicts what was asked for, or was told before.

        Returns
        -------
        Trial
            With its cost, on disk.

        Raises
        ------
        InputError
            The run was not asked for, or told already, or a gain is none; nothing is lost.
        RecordingError
            The recording was made at other gains or follows another reference, lacks the signal
            or is too short.
        """
        run = read_told(recording, self._sources.reading, self.experiment, anyway=anyway)
        stated = {**run.recording.parameters, **(gains or {})}
        request = chosen_request(self._waiting.real, trial, stated)
        if not anyway:
            run.refuse_repeated(self._store.events())
        used = told_gains(request, run.recording, self.gains, given=gains, anyway=anyway)
        source = self._sources.real(self.history.made)
        twin = source.content_hash if source else ""
        judged = self.history.envelope.judge(run.recording)
        told = self.history.trial("IS1", used, judged, twin=twin, number=request.number)
        file = {"file": run.file, "sha256": run.sha256, "after": self._store.highest}
        self.history.write(told)
        self._store.log("tell", number=request.number, gains=used, **file)
        self._waiting.answered(request.number)
        initial = len(self.history.of("IS1")) <= self.study.file.budget.initial_is1
        self._announce("initial" if initial else "query", told)
        return told

    def not_the_gains(self, trial: TrialRequest | int | None, why: str) -> TrialRequest:
        """Say that a requested run failed, but not because of its gains: `ask` returns it again.

        Parameters
        ----------
        trial : TrialRequest, int or None
            What `ask` returned, or its number. With None the run that is waited for.
        why : str
            Reason, in a few words.

        Returns
        -------
        TrialRequest
            The run, which is still waited for.

        Raises
        ------
        InputError
            The run was not asked for, or told already, or several are waited for.
        SimulationError
            It is the third in a row.
        """
        request = chosen_request(self._waiting.real, trial, {})
        log_not_the_gains(self._store, request.number, why)
        return request

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
            No first run of the twin succeeded, or three real ones in a row failed by the bench.
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
                    plant = self._proposals.axis(self._sources)
                    try:
                        run = play(plant, request.gains, self.experiment, self.history.envelope)
                    except NotTheGainsError as error:
                        self.not_the_gains(request, str(error))
                        continue
                    self.tell(request, scorable(run, self.experiment))
        except KeyboardInterrupt:
            self._store.log("interrupt", trials=len(self.history.trials))
            raise
        self._announce("done", self.history.trials[-1])
        return self.result()

    def watch(self, progress: ProgressCallback | None) -> None:
        """Report each finished run from now on.

        Parameters
        ----------
        progress : callable or None
            Called with a `Progress`.
        """
        self._watch = Watch(self.history, progress)

    def result(self) -> TuningResult:
        """Best and recommended gains as of now; logged, as is the end where no run is wanted."""
        recommendation = self._proposals.recommended()
        if recommendation is not None:
            self._store.log("recommendation", **asdict(recommendation))
        self._waiting.log_end()
        self._store.refresh_index()
        return TuningResult.of(
            self.history,
            recommendation,
            earlier=len(self._earlier),
            why_left_out=self._earlier.why_left_out,
            twin_versions=self._corrections.reasons,
            learned=self._corrections.learned,
        )

    @property
    def pending(self) -> TrialRequest | None:
        """Run that was asked for and not told yet; of several the first."""
        return next(iter(self._waiting.real.values()), None)

    @property
    def waiting(self) -> tuple[TrialRequest, ...]:
        """All runs that were asked for and not told yet, in order."""
        return tuple(self._waiting.real.values())

    def close(self) -> None:
        """Give back twins and the folder; everything told is on disk already."""
        self._closing.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _next(self, held: Mapping[str, float]) -> TrialRequest | None:
        """Do what must precede the next query, and decide on it."""
        if self._waiting.twin is not None:
            return self._waiting.twin
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
        real = len(self.history.of("IS1"))
        self._store.log("ask", **asdict(request), real=real)
        self.history.real_at_ask = real
        self.history.note_expected(request.number, request.expected)
        self._waiting.add(request)
        return request

    def _take_earlier(self) -> None:
        """Take over the runs of an earlier study, each as a real run of this one; once."""
        for position in range(len(self.history.of("IS1")), len(self._earlier)):
            self._twin.follow_up()  # of the one before
            taken = self._earlier.take(position, self.history)
            self._announce("initial", self.history.write(taken))

    def _announce(self, phase: Phase, trial: Trial) -> None:
        self._watch.tell(phase, trial, self._waiting.last)
