"""Conclude a diagnosis from the confirmed names: verdict, place, sizes, next experiment."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.fitted_starts import told_starts
from gmfbo.diagnosis.case.wider_ranges import stated_ranges
from gmfbo.diagnosis.comparison.numbers import MOST, named_log_odds
from gmfbo.diagnosis.comparison.priors import coordinates_of, inside
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.experiment.from_recordings import propose
from gmfbo.diagnosis.fitting.central_slopes import with_central_slopes
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.intervals import Spread, combinations_of, estimated
from gmfbo.diagnosis.locating.mismatch_place import locate, located_at
from gmfbo.diagnosis.locating.parities import parities
from gmfbo.diagnosis.naming.alignment_told import alignments
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.naming.decision_told import (
    augmentation_of,
    named_effects,
    not_testable,
    units_of,
)
from gmfbo.diagnosis.naming.open_explanations import predictions_of
from gmfbo.diagnosis.naming.shown_sizes import detectable_sizes
from gmfbo.diagnosis.outside.named_law import inferred_beside_law
from gmfbo.diagnosis.outside.unknown_shape import shape_of
from gmfbo.diagnosis.result.estimated import EstimatedParameter
from gmfbo.diagnosis.result.explained import Remainder
from gmfbo.diagnosis.result.findings import Cost, Sufficiency, Verdict
from gmfbo.diagnosis.result.next_experiment import NextExperiment
from gmfbo.diagnosis.result.reference_test import ResidualTest
from gmfbo.diagnosis.result.whereabouts import Location, Shape
from gmfbo.diagnosis.screening.port_response import PortResponse
from gmfbo.diagnosis.stage_times import Progress
from gmfbo.diagnosis.validating.drifting_parameters import drifts_of
from gmfbo.diagnosis.validating.reference_tests import residual_tests
from gmfbo.diagnosis.validating.remainder_place import remainder_of
from gmfbo.diagnosis.validating.validation import Validated
from gmfbo.physics import Units


@dataclass(frozen=True, eq=False)
class Conclusion:
    """Result of a search, and the diagnosis that follows from it.

    Attributes
    ----------
    case : Case
        Twin and recordings.
    unseen : Case or None
        Recordings that were only scored.
    decision : Decision
        The names that stand.
    reasons : dict of str to str
        Why an effect could not be tested.
    result : Validated
        Errors on recordings that were not fitted.
    response : PortResponse or None
        Answer of the outputs to a torque; None without a torque port.
    """

    case: Case
    unseen: Case | None
    decision: Decision
    reasons: dict[str, str]
    result: Validated
    response: PortResponse | None = None

    @cached_property
    def units(self) -> Units:
        """Units of the twin's ports and states."""
        return units_of(self.case)

    def diagnosis(self, seed: int, started: float, progress: Progress) -> Diagnosis:
        """Make the diagnosis.

        Parameters
        ----------
        seed, started
            As of `Search.diagnosis`.
        progress : callable (str, float)
            Called with the stage and the share done.
        """
        case, decision, result = self.case, self.decision, self.result
        spread = Spread(*result.part.intervals())
        progress("aligning the columns", 0.93)
        alignment = alignments(case, result.augmented, self.reasons)
        progress("locating", 0.95)
        names = [found.winner.name for found in decision.rounds]
        shares = {name: result.squares.share(name) for name in names}
        named = named_effects(decision, result.augmented, spread, self.units, shares, case.twin)
        untold = not_testable(self.reasons, decision)
        tests = residual_tests(self.unseen or case, result.curves, result.scored, result.augmented)
        verdict = self._verdict(tests)
        location = self._location(verdict)
        progress("choosing the next experiment", 0.97)
        experiment, reference = self._next_experiment()
        progress("done", 1.0)
        return Diagnosis(
            verdict=verdict,
            evidence=self._sufficiency,
            effects=named,
            parameters=self._parameters(spread),
            combinations=combinations_of(self._measured),
            alignment=alignment,
            detectable=detectable_sizes(
                decision.shown,
                case.setting.excitation,
                decision.unsettled | {e.name for e in untold},
                self.units,
            ),
            location=location,
            fit=result.fit,
            shape=self._shape,
            next_experiment=experiment,
            next_reference=reference,
            not_testable=untold,
            cost=Cost(case.simulations.runs, time.perf_counter() - started),
            seed=seed,
            versions=_versions(),
            notes=self._notes,
            predictions=predictions_of(case, decision, result.augmented, self.units),
            latent=self._latent,
            residual_tests=tests,
            remainder=self._remainder,
            converged=result.augmented.converged,
            curves=result.curves,
            augmentation=(
                None
                if result.fit.twin_is_withheld
                else augmentation_of(case, result.augmented, self.units)
            ),
        )

    @property
    def _notes(self) -> tuple[str, ...]:
        """Each remark once; those of unseen recordings are among the case's."""
        starts = told_starts(self.case, self.decision.model)
        return tuple(dict.fromkeys((*self.case.notes, *starts)))

    def _parameters(self, spread: Spread) -> dict[str, EstimatedParameter]:
        case, decision = self.case, self.decision
        found = estimated(self._measured, spread, case.twin, stated_ranges(case.twin))
        drifts = drifts_of(case, decision.compared, decision.row)
        return {
            name: replace(
                one,
                drifts=drifts.get(name) if one.identifiable else None,
                set=() if (wrong := decision.freed.get(name)) is None else wrong.set,
                probability=None if wrong is None else wrong.probability,
            )
            for name, one in found.items()
        }

    @cached_property
    def _remainder(self) -> Remainder | None:
        share = self.result.squares.remainder
        if share is None and self.decision.stand_ins:
            share = 0.0
        if share is None:
            return None
        return remainder_of(self.case, self.decision, share)

    @cached_property
    def _measured(self) -> Fitted:
        """The augmented twin with sensitivities that tell what these recordings cannot see."""
        return with_central_slopes(self.result.misfit, self.result.augmented)

    def _location(self, verdict: Verdict) -> Location:
        if verdict not in ("missing_physics", "outside_library"):
            return Location(None)
        case, augmented = self.case, self.result.augmented
        effects = augmented.hypothesis.effects
        location = locate(
            case,
            case.base,
            parities(case, case.base),
            effects,
            augmented if effects else None,
            self.units,
        )
        unknown = self.decision.unknown
        if verdict == "outside_library" and unknown is not None and not self.decision.rounds:
            return located_at(location, unknown.port, unknown.against)
        return location

    def _next_experiment(self) -> tuple[NextExperiment | None, str]:
        """Next experiment, where rivals remain or friction was not excited, and its file's text."""
        case, decision = self.case, self.decision
        rivals = next((r for r in decision.rounds if r.rivals), None)
        with TemporaryDirectory() as folder:
            told = None
            if rivals is not None:
                fits = [rivals.winner.fitted, *(r.fitted for r in rivals.rivals)]
                told = propose(case, fits, folder=Path(folder))
            elif self._sufficiency == "insufficient":
                silent = [n for n, why in self.reasons.items() if why.startswith("not excited")]
                told = propose(case, [case.base], silent, Path(folder))
            if told is None or not told.reference:
                return told, ""
            return told, (Path(folder) / told.reference).read_text(encoding="utf-8")

    @property
    def _shape(self) -> Shape | None:
        """Curve of what is unknown, where it can be drawn."""
        unknown = self.decision.shown_unknown
        return None if unknown is None else shape_of(unknown, self.units)

    @property
    def _latent(self) -> Shape | None:
        """What acts at the torque port, inferred beside the named law; None without such a law."""
        if not self.decision.rounds:
            return None
        return inferred_beside_law(self.case, self.result.augmented, self.response, self.units)

    def _verdict(self, tests: Sequence[ResidualTest]) -> Verdict:
        decision = self.decision
        left = self.result.squares.remainder
        explains_little = bool(decision.rounds) and left is not None and left > MOST
        if decision.is_outside or explains_little or self._is_mismatch(tests):
            return "outside_library"
        if decision.rounds:
            return "missing_physics"
        return "parameters" if decision.freed or self._parameters_matter else "none"

    def _is_mismatch(self, tests: Sequence[ResidualTest]) -> bool:
        """Whether laws explain little of what is left, and most of that follows the reference.

        Asked where no smooth torque can stand for what is missing, since the twin has no port.
        """
        compared = self.decision.compared
        has_port = "torque" in compared.ledger.kernels.kernels
        share, signals = self.decision.share, self.result.fit.signals
        if has_port or share is None or share >= MOST:
            return False
        errors = {
            name: one.augmented if self.decision.row.elements else one.parameters_only
            for name, one in signals.items()
        }
        return any(t.follows > max(t.bound, MOST * errors[t.signal]) for t in tests)

    @property
    def _parameters_matter(self) -> bool:
        """Whether the recordings tell the refitted twin from the twin as it came."""
        base, compared = self.decision.base, self.decision.compared
        problem, whitening = compared.search.problem, compared.ledger.whitening
        refitted = problem.without_counts(base.hypothesis.point(base.x))
        as_it_came = problem.as_it_came(self.case.nominal)
        nominal, fitted = (
            whitening.square(problem.residual(problem.values(runs), base.nuisances))
            for runs in (as_it_came, *self.case.simulations.run([refitted]))
        )
        return 0.5 * (nominal - fitted) > named_log_odds() and self._are_elsewhere

    @property
    def _are_elsewhere(self) -> bool:
        """Whether the refitted values are believed to lie elsewhere than the twin's.

        Where the remainder is more than noise, as of a twin that counts, squares fall by chance.
        """
        part = self.result.part
        came = coordinates_of(part.fitted.priors, part.fitted.hypothesis.start({}))
        return part.log_odds_against(inside(part.fitted.priors, came)) > named_log_odds()

    @property
    def _sufficiency(self) -> Sufficiency:
        silent = [name for name, why in self.reasons.items() if why.startswith("not excited")]
        return "insufficient" if "coulomb_friction" in silent else "sufficient"


def _versions() -> dict[str, str]:
    from importlib.metadata import version

    return {name: version(name) for name in ("gmfbo", "numpy", "scipy", "fmpy")}
