"""Findings of a diagnosis, as values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from typing import Literal

from gmfbo.diagnosis.result.augmentation import Augmentation
from gmfbo.diagnosis.result.curve import Curve
from gmfbo.diagnosis.result.estimated import Alignment, Combination, EstimatedParameter
from gmfbo.diagnosis.result.explained import Remainder
from gmfbo.diagnosis.result.held_out_errors import Fit
from gmfbo.diagnosis.result.named_effect import DetectableSize, NamedEffect, NotTestable
from gmfbo.diagnosis.result.next_experiment import NextExperiment
from gmfbo.diagnosis.result.predictions import Predictions
from gmfbo.diagnosis.result.reference_test import ResidualTest
from gmfbo.diagnosis.result.whereabouts import Location, Shape

Verdict = Literal["none", "parameters", "missing_physics", "outside_library"]
Sufficiency = Literal["sufficient", "insufficient"]


@dataclass(frozen=True)
class Cost:
    """Cost of a diagnosis.

    Attributes
    ----------
    simulations : int
        Runs of the twin, one recording each.
    seconds : float
        [s] Wall-clock time.
    stages : mapping of str to float
        [s] Of it, by stage, in the order in which they began.
    """

    simulations: int
    seconds: float
    stages: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, repr=False)
class Findings:
    """Fields of a `gmfbo.Diagnosis`, which adds what can be done with them.

    Attributes
    ----------
    verdict : {"none", "parameters", "missing_physics", "outside_library"}
        Nothing beyond noise; the twin's uncertain values explain it; at least one named effect;
        or a mismatch that no known effect explains.
    evidence : {"sufficient", "insufficient"}
        Whether these recordings suffice; if not, the verdict names only what is certain.
    effects : tuple of NamedEffect
        Named effects, strongest evidence first.
    parameters : mapping of str to EstimatedParameter
        The twin's uncertain parameters, refitted.
    combinations : tuple of Combination
        Identifiable combinations of parameters that are not identifiable alone.
    alignment : mapping of str to Alignment
        How each signal was logged.
    detectable : mapping of str to DetectableSize
        For each effect that is not named, the smallest size that would have shown.
    location : Location
        Where the mismatch sits.
    fit : Fit
        Errors on held-out recordings.
    shape : Shape or None
        The inferred signal where the verdict is `outside_library` and a curve over one state shows
        most of it, beside nothing but named laws.
    next_experiment : NextExperiment or None
        Next experiment, if it would tell more.
    not_testable : tuple of NotTestable
        Effects that could not be tested, and why.
    cost : Cost
        Simulations and time.
    seed : int
        Seed of all randomness.
    versions : mapping of str to str
        Versions of the software.
    notes : tuple of str
        Remarks, such as numerical limits.
    predictions : Predictions or None
        Explanations that remain, with the values that predict a recording under each.
    latent : Shape or None
        Latent torque at the torque port, inferred without a law, where physics was named.
    residual_tests : tuple of ResidualTest
        Whether a residual still follows the reference, on held-out recordings.
    converged : bool
        Whether the fit that gave these values ended by itself; False where it was stopped.
    remainder : Remainder or None
        What no law explains; None where no more than noise is left.
    not_compared : tuple of str
        Outputs of the twin that a recording does not hold: signal, recording and nearest column.
    curves : tuple of Curve
        Signals before and after, for plots; not part of the JSON.
    augmentation : Augmentation or None
        Values of the augmented twin; not part of the JSON.
    exported : Path or None
        Twin file of an augmented twin that was saved before, where this was read from a folder.
    next_reference : str
        Text of the file with the next reference; not part of the JSON.
    """

    verdict: Verdict
    evidence: Sufficiency
    effects: tuple[NamedEffect, ...]
    parameters: Mapping[str, EstimatedParameter]
    combinations: tuple[Combination, ...]
    alignment: Mapping[str, Alignment]
    detectable: Mapping[str, DetectableSize]
    location: Location
    fit: Fit
    shape: Shape | None
    next_experiment: NextExperiment | None
    not_testable: tuple[NotTestable, ...]
    cost: Cost
    seed: int
    versions: Mapping[str, str]
    notes: tuple[str, ...] = ()
    predictions: Predictions | None = None
    latent: Shape | None = None
    residual_tests: tuple[ResidualTest, ...] = ()
    converged: bool = True
    remainder: Remainder | None = None
    not_compared: tuple[str, ...] = ()
    curves: tuple[Curve, ...] = field(default=(), compare=False)
    augmentation: Augmentation | None = field(default=None, compare=False)
    exported: Path | None = field(default=None, compare=False)
    next_reference: str = field(default="", compare=False)

    @property
    def statement_probability(self) -> float | None:
        """Probability of all that the sentence says is missing or wrong; None where none is known.

        The probability of an effect is given those that were named before it, so that of several
        together is the product (chain rule). Of a set it is that of the set. That nothing is
        missing, or something unknown, has no probability.
        """
        if self.verdict not in ("missing_physics", "parameters"):
            return None
        told = [effect.set_probability for effect in self.effects]
        moved = [one for one in self.parameters.values() if one.is_moved]
        told += [one.probability for one in moved if one.probability is not None]
        return prod(told) if told else None
