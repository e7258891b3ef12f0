"""The steps of a diagnosis after its case was opened, in their order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.held_out_split import Split, split_of
from gmfbo.diagnosis.comparison.numbers import MOST
from gmfbo.diagnosis.conclusion import Conclusion
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.naming.decided_by_score import decide, measured
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.screening.exclusion import Excluded
from gmfbo.diagnosis.screening.searched_lines import SearchedLines
from gmfbo.diagnosis.screening.testable_effects import (
    NOT_EXCITED_BY_REVERSALS,
    ONE_WAY_FRICTION,
    untestable,
)
from gmfbo.diagnosis.stage_times import Progress
from gmfbo.diagnosis.validating.validation import Validated, validate_unseen
from gmfbo.diagnosis.validating.validation import validate as validated_on
from gmfbo.diagnosis.validating.withdrawn import met_worse_with, without_name, without_names
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
    assume : sequence of str
        Effects that are tested in any case.
    excluded : Excluded
        Effects that are not considered, and parameters of the twin that nobody may doubt.
    progress : callable (str, float)
        Called with the stage and the share done.
    """

    def __init__(
        self,
        case: Case,
        rng: np.random.Generator,
        assume: Sequence[str],
        excluded: Excluded,
        progress: Progress,
    ) -> None:
        self.case, self.rng, self.progress = case, rng, progress
        self.assume, self.excluded = assume, excluded
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
        case.base = measured(case.misfit, decision.base)
        case.notes.extend(decision.notes)
        self.progress("validating", 0.85)
        decision, result = self._with_nearest(*self._confirmed(decision, unseen), unseen)
        decision = _held_against(decision, result)
        found = Conclusion(case, unseen, decision, reasons, result, self.lines.response)
        return found.diagnosis(seed, started, self.progress)

    def _decision(self, reasons: dict[str, str]) -> Decision:
        testable = [name for name in CATALOGUE if name not in reasons]
        silent = [
            name
            for name, why in reasons.items()
            if why == NOT_EXCITED_BY_REVERSALS and not CATALOGUE[name].shows_at_turns
        ]
        if silent and ONE_WAY_FRICTION in testable:
            silent.append(ONE_WAY_FRICTION)
        return decide(
            self.case,
            testable,
            self.lines.passing(testable),
            self.progress,
            silent=silent,
            held=self.excluded.parameters,
        )

    def _reasons(self) -> dict[str, str]:
        return untestable(
            self.case.twin.file,
            self.case.setting.excitation,
            assume=self.assume,
            exclude=self.excluded.effects,
            has_inertia=self.case.setting.inertia is not None,
            is_open=self.case.simulations.tracking is not None,
        )

    def _confirmed(self, decision: Decision, unseen: Case | None) -> tuple[Decision, Validated]:
        """Score on held-out recordings, and withdraw names with which these are met no better."""
        result = self._validated(decision, unseen)
        while (name := _met_worse_with(decision, result)) is not None:
            self.case.notes.append(
                f"{words(name)} would explain the recordings that were fitted, but the others are "
                "met worse with it: it is not named"
            )
            decision = without_name(self.case, decision, name)
            result = self._validated(decision, unseen)
        is_useless = result.contradicts_names or result.gains_nothing
        if not decision.row.elements or not is_useless:
            return decision, result
        names = " and ".join(words(name) for name in sorted(decision.row.elements))
        why = "contradict it" if result.contradicts_names else "are met no better with it"
        self.case.notes.append(
            f"{names} would explain the recordings that were fitted, but the others {why}: "
            "nothing is named"
        )
        withdrawn = without_names(self.case, decision, contradicted=result.contradicts_names)
        return withdrawn, self._validated(withdrawn, unseen)

    def _with_nearest(
        self, decision: Decision, result: Validated, unseen: Case | None
    ) -> tuple[Decision, Validated]:
        """Have laws stand in for what is unknown, if they explain most of it where it is unseen."""
        nearest = decision.nearest
        if nearest is None:
            return decision, result
        standing = replace(
            decision,
            row=nearest,
            model=measured(self.case.misfit, nearest),
            stand_ins=tuple(sorted(nearest.elements - decision.row.elements)),
        )
        found = self._validated(standing, unseen)
        refused = found.contradicts_names or found.gains_nothing or found.fit.twin_is_withheld
        left, before = found.squares.remainder or 0.0, result.squares.remainder or 1.0
        return (decision, result) if refused or left > MOST * before else (standing, found)

    def _validated(self, decision: Decision, unseen: Case | None) -> Validated:
        case = self.case
        if unseen is not None:
            return validate_unseen(case, unseen, decision)
        models = [case.base, decision.model] if decision.row.elements else [case.base]
        changes = [
            tuple(a - b for a, b in zip(with_it.residual, without.residual, strict=True))
            for without, with_it in pairwise(models)
        ]
        split = split_of(case, changes, decision.model)
        return validated_on(case, decision, split, self._with_unknown(decision, split))

    def _with_unknown(self, decision: Decision, split: Split) -> list[Simulated] | None:
        """The recordings with a free function, of which held-out ones have no part in the fit.

        None without such a function, or where only stretches of recordings are held out.
        """
        if decision.shown_unknown is None:
            return None
        windows = self.case.budget.windows
        unseen = {windows[i].record for i in split.held_out}
        if unseen & {windows[i].record for i in split.fitted}:
            return None
        return decision.shown_unknown.function.played(unseen)


def _met_worse_with(decision: Decision, result: Validated) -> str | None:
    """One of several names that held-out recordings speak against; a last one is judged by G."""
    names = [found.winner.name for found in decision.rounds]
    return met_worse_with(names, result.squares) if len(names) > 1 else None


def _held_against(decision: Decision, result: Validated) -> Decision:
    """A decision with the probabilities that held-out recordings leave its names."""
    left = result.squares.remainder or 0.0
    rounds = tuple(one.held_against(left) for one in decision.rounds)
    freed = {name: one.held_against(left) for name, one in decision.freed.items()}
    return replace(decision, rounds=rounds, freed=freed)
