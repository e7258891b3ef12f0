"""The steps of a diagnosis after its case was opened, in their order."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case, is_more_than_noise
from gmfbo.diagnosis.case.held_out_split import Split, split_of
from gmfbo.diagnosis.case.other_starts import fitted_from_names
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.experiment.from_recordings import propose, propose_for
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.fitting.intervals import combinations_of, estimated, spread_of
from gmfbo.diagnosis.fitting.profile_intervals import widened_by_profile
from gmfbo.diagnosis.locating.mismatch_place import locate, located_at
from gmfbo.diagnosis.locating.parities import parities
from gmfbo.diagnosis.naming.decision import Decision, Round
from gmfbo.diagnosis.naming.decision_told import (
    alignments,
    augmentation_of,
    detectable_sizes,
    named_effects,
    not_testable,
    units_of,
)
from gmfbo.diagnosis.naming.forward_selection import decide
from gmfbo.diagnosis.naming.open_explanations import predictions_of
from gmfbo.diagnosis.naming.probability import probability
from gmfbo.diagnosis.naming.withdrawn_names import (
    drop_improbable,
    give_way_to_limit,
    is_known,
    is_weak,
    leaves_most,
    note_what_is_not_named,
    parameters_matter,
)
from gmfbo.diagnosis.outside.beyond_library import (
    Outside,
    is_mismatch,
    is_uneven,
    look_outside,
    unexplained,
)
from gmfbo.diagnosis.result.findings import Cost, Sufficiency, Verdict
from gmfbo.diagnosis.result.held_out_errors import Fit
from gmfbo.diagnosis.result.next_experiment import NextExperiment
from gmfbo.diagnosis.result.reference_test import ResidualTest
from gmfbo.diagnosis.result.whereabouts import Location, Shape
from gmfbo.diagnosis.screening.port_response import PortResponse, measure_port_response
from gmfbo.diagnosis.screening.pulses import EVERY, Pulse
from gmfbo.diagnosis.screening.repeating_and_passing import find_lines
from gmfbo.diagnosis.screening.testable_effects import (
    NOT_EXCITED_BY_REVERSALS,
    candidates,
    untestable,
)
from gmfbo.diagnosis.validating.reference_tests import residual_tests
from gmfbo.diagnosis.validating.validation import Validated, validate_unseen
from gmfbo.diagnosis.validating.validation import validate as validated_on
from gmfbo.physics import CATALOGUE, Excitation
from gmfbo.plain_words import words

Progress = Callable[[str, float], None]


class Search:
    """The steps after a case was opened.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    rng : numpy Generator
        Of all randomness.
    assume, exclude : sequence of str
        Effects that are tested in any case, and that are not considered.
    progress : callable (str, float)
        Told the stage and the share that is done.
    """

    def __init__(
        self,
        case: Case,
        rng: np.random.Generator,
        assume: Sequence[str],
        exclude: Sequence[str],
        progress: Progress,
    ) -> None:
        self.case, self.rng, self.progress = case, rng, progress
        self.assume, self.exclude = assume, exclude
        self.units = units_of(case)
        self._response: PortResponse | None = None
        self._pulses: tuple[Pulse, ...] = ()

    def diagnosis(self, seed: int, started: float, unseen: Case | None) -> Diagnosis:
        """Go through all steps.

        Parameters
        ----------
        seed : int
            To be told.
        started : float
            [s] When, by `time.perf_counter`.
        unseen : Case or None
            Recordings that are only scored; without them, part of the case's own are held out.
        """
        case = self.case
        self._look_for_lines()
        reasons = self._reasons()
        decision = self._decision(reasons)
        probabilities = self._probabilities(decision)
        give_way_to_limit(case, decision, probabilities, self._probability(decision))
        drop_improbable(case, decision, probabilities)
        outside = None
        if self._response is not None:
            self.progress("looking outside the library", 0.8)
            outside = look_outside(case, decision, self._response, self.rng)
            if outside.is_better:
                decision.too_small = None
            if outside.is_better and not is_known(decision):
                decision.model = case.base
                decision.rounds.clear()
        note_what_is_not_named(case, decision)
        if leaves_most(case, decision):
            self._take_names_back(decision, "leaves most of what is beyond noise")
        self.progress("validating", 0.85)
        result = self._validated(decision, outside, unseen)
        why = None
        if result.fit.removes_nothing and is_weak(decision):
            removed = result.fit.explainable_error_removed
            why = f"removes {removed:.0%} of the explainable error on the others"
        elif decision.rounds and result.contradicts_names:
            why = "the others contradict it"
            decision.contradicted = not is_weak(decision)
        if why is not None:
            self._take_names_back(decision, why)
            result = self._validated(decision, outside, unseen)
        elif decision.rounds and result.fit.is_worse:
            case.notes.append(_why_worse(result))
        augmented = result.augmented
        own = len(case.setting.uncertain)
        of_effects = range(own, augmented.x.size)
        spread = widened_by_profile(
            result.misfit, augmented, spread_of(augmented, self.rng), of_effects
        )
        self.progress("locating", 0.95)
        named = named_effects(case, decision, augmented, spread, probabilities, self.units)
        effects = augmented.hypothesis.effects
        tests = residual_tests(unseen or case, result.curves, result.scored)
        verdict = self._verdict(decision, outside, tests, result.fit)
        location = Location(None)
        if verdict in ("missing_physics", "outside_library"):
            location = locate(
                case,
                case.base,
                parities(case, case.base),
                effects,
                augmented if effects else None,
                self.units,
            )
            if verdict == "outside_library" and outside is not None and outside.is_better:
                location = located_at(location, outside.model.port)
        self.progress("choosing the next experiment", 0.97)
        experiment, reference = self._next_experiment(decision, reasons)
        self.progress("done", 1.0)
        return Diagnosis(
            verdict=verdict,
            evidence=self._sufficiency(reasons),
            effects=named,
            parameters=estimated(augmented, spread, case.twin.binding),
            combinations=combinations_of(augmented, spread),
            alignment=alignments(case, augmented),
            detectable=detectable_sizes(case, decision, [e.name for e in named], self.units),
            location=location,
            fit=result.fit,
            shape=self._shape(outside) if outside is not None and outside.is_better else None,
            next_experiment=experiment,
            next_reference=reference,
            not_testable=not_testable(case, reasons, decision),
            cost=Cost(case.simulations.runs, time.perf_counter() - started),
            seed=seed,
            versions=_versions(),
            notes=tuple(case.notes),
            predictions=predictions_of(case, decision, augmented, self.units),
            latent=self._latent(outside, decision),
            residual_tests=tests,
            curves=result.curves,
            augmentation=augmentation_of(case, augmented, self.units),
        )

    def _decision(self, reasons: dict[str, str]) -> Decision:
        """What to name, about the best fit without names."""
        case, decision = self.case, self._about_the_fit(reasons)
        if not decision.rounds:
            return decision
        assert decision.model is not None
        better = fitted_from_names(case, decision.model)
        if better is None:
            return decision
        case.base = better
        case.use(case.plain)
        self._look_for_lines()
        return self._about_the_fit(reasons)

    def _about_the_fit(self, reasons: dict[str, str]) -> Decision:
        """What to name, about the twin as it is refitted so far."""
        excitation = self.case.setting.excitation
        testable = [name for name in CATALOGUE if name not in reasons]
        library = candidates(testable, excitation) + self._passing(testable)
        silent = [name for name, why in reasons.items() if why == NOT_EXCITED_BY_REVERSALS]
        library += candidates(silent, excitation)
        return decide(
            self.case,
            library,
            self.rng,
            self.progress,
            silent=silent,
            look_again=lambda model: self._lines_beside(model, testable),
        )

    def _look_for_lines(self) -> None:
        """Let what repeats in the misfit say which lines are worth testing."""
        case = self.case
        if "torque" not in case.base.simulated[0].response.ports:
            return
        self.progress("searching for lines", 0.1)
        self._response = response = measure_port_response(case, "torque", self.rng)
        if response is None:
            return
        lines = find_lines(case, case.base, response)
        self._pulses = lines.passing
        excitation = lines.within(case.setting.excitation)
        case.change_setting(replace(case.setting, excitation=excitation))

    def _lines_beside(self, model: Fitted, testable: Sequence[str]) -> list[Candidate]:
        """Lines and pulses beside named effects, as starts of the effects that need one."""
        if self._response is None:
            return []
        lines = find_lines(self.case, model, self._response)
        self._pulses = lines.passing
        excitation = lines.within(self.case.setting.excitation)
        searched = [name for name in testable if CATALOGUE[name].is_searched]
        return candidates(searched, excitation) + self._passing(testable, excitation)

    def _passing(
        self, testable: Sequence[str], excitation: Excitation | None = None
    ) -> list[Candidate]:
        """A disturbance that passed in one recording, as a candidate in that one alone."""
        name = "pulse_disturbance"
        if name not in testable:
            return []
        return [
            Candidate(name, dict(start), only=pulse.record)
            for start, pulse in zip(
                CATALOGUE[name].starts(excitation or self.case.setting.excitation),
                self._pulses,
                strict=False,
            )
            if pulse.record != EVERY
        ]

    def _reasons(self) -> dict[str, str]:
        return untestable(
            self.case.twin.file,
            self.case.setting.excitation,
            assume=self.assume,
            exclude=self.exclude,
            has_inertia=self.case.setting.inertia is not None,
            is_open=self.case.simulations.tracking is not None,
        )

    def _next_experiment(
        self, decision: Decision, reasons: dict[str, str]
    ) -> tuple[NextExperiment | None, str]:
        """What to record next where rivals remain or much was not excited, and its file's text."""
        case = self.case
        rivals = next((r for r in decision.rounds if r.rivals), None)
        with TemporaryDirectory() as folder:
            told = None
            if rivals is not None:
                fits = [rivals.winner.fitted, *(r.fitted for r in rivals.rivals)]
                told = propose(case, fits, decision.threshold, Path(folder))
            elif self._sufficiency(reasons) == "insufficient":
                silent = [n for n, why in reasons.items() if why.startswith("not excited")]
                told = propose_for(case, case.base, silent, Path(folder))
            if told is None or not told.reference:
                return told, ""
            return told, (Path(folder) / told.reference).read_text(encoding="utf-8")

    def _validated(
        self, decision: Decision, outside: Outside | None, unseen: Case | None
    ) -> Validated:
        case, model = self.case, decision.model
        assert model is not None
        least = min(decision.left, unexplained(case, model))
        if unseen is not None:
            return validate_unseen(case, unseen, model, least)
        models = [case.base, *(entry.winner.fitted for entry in decision.rounds)]
        changes = [
            tuple(a - b for a, b in zip(with_it.residual, without.residual, strict=True))
            for without, with_it in pairwise(models)
        ]
        split = split_of(case, changes, model)
        return validated_on(case, model, split, self._unnamed_change(outside, split), decision.left)

    def _take_names_back(self, decision: Decision, why: str) -> None:
        """Name nothing where that would not help."""
        names = " and ".join(words(entry.winner.name) for entry in decision.rounds)
        self.case.notes.append(
            f"{names} would explain the recordings that were fitted, but {why}: nothing is named"
        )
        decision.refused = [entry.winner for entry in decision.rounds]
        decision.rounds.clear()
        decision.model = self.case.base

    def _probabilities(self, decision: Decision) -> dict[str, float]:
        found, base = {}, self.case.base
        again = decision.beside_rest
        for entry in decision.rounds:
            name = entry.winner.name
            judged = base, entry
            if again is not None and again.entry.winner.name == name:
                judged = again.without, again.entry
            found[name] = self._probability(decision)(*judged)
            base = entry.winner.fitted
        return found

    def _probability(self, decision: Decision) -> Callable[[Fitted, Round], float]:
        return lambda base, entry: probability(base, entry, decision.dispersion, self.rng)

    def _unnamed_change(
        self, outside: Outside | None, split: Split
    ) -> list[Sequence[NDArray[np.float64]]] | None:
        """What a free function changes in each recording, by a fit that sees the fitted ones."""
        if outside is None:
            return None
        windows = self.case.budget.windows
        unseen = {windows[i].record for i in split.held_out}
        whole = unseen - {windows[i].record for i in split.fitted}
        records = range(len(self.case.simulations.records))
        return [outside.model.predicted(k, without=whole) for k in records]

    def _shape(self, outside: Outside | None) -> Shape | None:
        if outside is None:
            return None
        units = self.units
        return outside.model.shape(
            {
                "torque": units.torque,
                "sensor": units.position,
                "command": units.command,
                "position": units.position,
                "velocity": units.velocity,
            }
        )

    def _latent(self, outside: Outside | None, decision: Decision) -> Shape | None:
        """The unnamed signal beside the names that it was found under, where they act there too."""
        at_torque = [r for r in decision.rounds if r.winner.effect.law.port == "torque"]
        return self._shape(outside) if at_torque else None

    def _verdict(
        self,
        decision: Decision,
        outside: Outside | None,
        tests: Sequence[ResidualTest],
        fit: Fit,
    ) -> Verdict:
        case = self.case
        if outside is not None and outside.is_better and not is_known(decision):
            return "outside_library"
        if decision.rounds:
            return "missing_physics"
        errors = {name: signal.parameters_only for name, signal in fit.signals.items()}
        left = unexplained(case, case.base)
        if not is_known(decision) and (
            decision.contradicted
            or (decision.disputed is not None and is_more_than_noise(case, case.base))
            or is_mismatch(left, tests, errors)
            or is_uneven(case, case.base, self.rng)
        ):
            return "outside_library"
        return "parameters" if parameters_matter(case, decision) else "none"

    def _sufficiency(self, reasons: dict[str, str]) -> Sufficiency:
        silent = [name for name, why in reasons.items() if why.startswith("not excited")]
        return "insufficient" if "coulomb_friction" in silent else "sufficient"


def _versions() -> dict[str, str]:
    from importlib.metadata import version

    return {name: version(name) for name in ("gmfbo", "numpy", "scipy", "fmpy")}


def _why_worse(result: Validated) -> str:
    """Why RMS errors that grew with the named physics do not speak against it."""
    if result.augmented.hypothesis.noise is not None:
        return (
            "the errors are of the augmented twin without its sensor's noise, which bridges "
            "part of the named physics: under the noise as it was recorded they are smaller"
        )
    removed = result.fit.explainable_error_removed or 0.0
    return (
        f"the named physics removes {removed:.0%} of what physics can explain on unseen runs, "
        "while their RMS errors grow: where the axis comes to rest within friction or a gap is "
        "chance"
    )
