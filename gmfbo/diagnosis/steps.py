"""The steps of a diagnosis after its case was opened, in their order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.held_out_split import Split, split_of
from gmfbo.diagnosis.case.other_starts import fitted_from_names
from gmfbo.diagnosis.conclusion import Conclusion
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.naming.decision import Decision, Round
from gmfbo.diagnosis.naming.forward_selection import decide
from gmfbo.diagnosis.naming.probability import probability
from gmfbo.diagnosis.naming.withdrawn_names import (
    drop_improbable,
    give_way_to_limit,
    is_known,
    is_weak,
    leaves_most,
    note_what_is_not_named,
)
from gmfbo.diagnosis.outside.beyond_library import (
    Outside,
    look_outside,
    unexplained,
)
from gmfbo.diagnosis.result.removed_error import rounded_down
from gmfbo.diagnosis.screening.searched_lines import SearchedLines
from gmfbo.diagnosis.screening.testable_effects import (
    NOT_EXCITED_BY_REVERSALS,
    candidates,
    untestable,
)
from gmfbo.diagnosis.stage_times import Progress
from gmfbo.diagnosis.validating.validation import Validated, validate_unseen
from gmfbo.diagnosis.validating.validation import validate as validated_on
from gmfbo.physics import CATALOGUE
from gmfbo.plain_words import words


class Search:
    """The steps after a case was opened.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    rng : numpy Generator
        Source of all random draws.
    assume, exclude : sequence of str
        Effects that are tested in any case, and that are not considered.
    progress : callable (str, float)
        Called with the stage and the share done.
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
        self.lines = SearchedLines(case, rng)

    def diagnosis(self, seed: int, started: float, unseen: Case | None) -> Diagnosis:
        """Go through all steps.

        Parameters
        ----------
        seed : int
            Seed, for the result.
        started : float
            [s] Start of the diagnosis by `time.perf_counter`.
        unseen : Case or None
            Recordings that are only scored; without them, part of the case's own are held out.
        """
        case = self.case
        self.lines.look(self.progress)
        reasons = self._reasons()
        decision = self._decision(reasons)
        probabilities = self._probabilities(decision)
        give_way_to_limit(case, decision, probabilities, self._probability(decision))
        drop_improbable(case, decision, probabilities)
        outside = self._outside(decision)
        note_what_is_not_named(case, decision)
        if leaves_most(case, decision):
            self._take_names_back(decision, "leaves most of what is beyond noise")
        self.progress("validating", 0.85)
        result = self._confirmed(decision, outside, unseen)
        found = Conclusion(case, unseen, decision, probabilities, reasons, outside, result)
        return found.diagnosis(seed, started, self.rng, self.progress)

    def _decision(self, reasons: dict[str, str]) -> Decision:
        """Decide on names, from the best fit without names."""
        case, decision = self.case, self._about_the_fit(reasons)
        if not decision.rounds:
            return decision
        assert decision.model is not None
        better = fitted_from_names(case, decision.model)
        if better is None:
            return decision
        case.base = better
        case.use(case.plain)
        self.lines.look(self.progress)
        return self._about_the_fit(reasons)

    def _about_the_fit(self, reasons: dict[str, str]) -> Decision:
        """Decide on names, from the present refit of the twin."""
        excitation = self.case.setting.excitation
        testable = [name for name in CATALOGUE if name not in reasons]
        library = candidates(testable, excitation) + self.lines.passing(testable)
        silent = [name for name, why in reasons.items() if why == NOT_EXCITED_BY_REVERSALS]
        library += candidates(silent, excitation)
        return decide(
            self.case,
            library,
            self.rng,
            self.progress,
            silent=silent,
            look_again=lambda model: self.lines.beside(model, testable),
        )

    def _reasons(self) -> dict[str, str]:
        return untestable(
            self.case.twin.file,
            self.case.setting.excitation,
            assume=self.assume,
            exclude=self.exclude,
            has_inertia=self.case.setting.inertia is not None,
            is_open=self.case.simulations.tracking is not None,
        )

    def _outside(self, decision: Decision) -> Outside | None:
        """Fit free functions, which replace names that they beat; None without a response."""
        if self.lines.response is None:
            return None
        self.progress("looking outside the library", 0.8)
        outside = look_outside(self.case, decision, self.lines.response, self.rng)
        if outside.is_better:
            decision.too_small = None
        if outside.is_better and not is_known(decision):
            decision.model = self.case.base
            decision.rounds.clear()
        return outside

    def _confirmed(
        self, decision: Decision, outside: Outside | None, unseen: Case | None
    ) -> Validated:
        """Score on held-out recordings, and withdraw names that these contradict."""
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
            return self._validated(decision, outside, unseen)
        if decision.rounds and result.fit.is_worse:
            self.case.notes.append(_why_worse(result))
        return result

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
        """Withdraw all names, and note the reason."""
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
        """Change of each recording's signals by the free function, fitted without held-out ones."""
        if outside is None:
            return None
        windows = self.case.budget.windows
        unseen = {windows[i].record for i in split.held_out}
        whole = unseen - {windows[i].record for i in split.fitted}
        records = range(len(self.case.simulations.records))
        return [outside.model.predicted(k, without=whole) for k in records]


def _why_worse(result: Validated) -> str:
    """Why RMS errors that grew with the named physics do not speak against it."""
    if result.augmented.hypothesis.noise is not None:
        return (
            "the errors are of the augmented twin without its sensor's noise, which bridges "
            "part of the named physics: under the noise as it was recorded they are smaller"
        )
    removed = result.fit.explainable_error_removed or 0.0
    return (
        f"the named physics removes {rounded_down(removed)} of what physics can explain on unseen "
        "runs, while their RMS errors grow: where the axis comes to rest within friction or a gap "
        "is chance"
    )
