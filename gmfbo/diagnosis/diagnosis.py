"""What a diagnosis found, as values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from gmfbo.diagnosis.augmentation import Augmentation
from gmfbo.diagnosis.curve import Curve
from gmfbo.diagnosis.estimates import Alignment, Combination, EstimatedParameter
from gmfbo.diagnosis.fit_table import Fit
from gmfbo.diagnosis.named_effect import DetectableSize, NamedEffect, NotTestable
from gmfbo.diagnosis.predictions import Predictions
from gmfbo.diagnosis.residual_test import ResidualTest
from gmfbo.diagnosis.suggested_experiment import NextExperiment
from gmfbo.diagnosis.whereabouts import Location, Shape
from gmfbo.errors import InputError

if TYPE_CHECKING:
    from gmfbo.sources.twin import FmuTwin

Verdict = Literal["none", "parameters", "missing_physics", "outside_library"]
Sufficiency = Literal["sufficient", "insufficient"]


@dataclass(frozen=True)
class Cost:
    """What a diagnosis took.

    Attributes
    ----------
    simulations : int
        Runs of the twin, one recording each.
    seconds : float
        [s] Wall-clock time.
    """

    simulations: int
    seconds: float


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """Why simulation and recordings differ: the physics left out, and the fit with it.

    Attributes
    ----------
    verdict : {"none", "parameters", "missing_physics", "outside_library"}
        Nothing beyond noise; the twin's uncertain values explain it; at least one named effect;
        or a mismatch that no known effect explains, whose `shape` was inferred.
    evidence : {"sufficient", "insufficient"}
        Whether these recordings can tell; if not, the verdict names only what is certain.
    effects : tuple of NamedEffect
        What is missing, strongest evidence first.
    parameters : mapping of str to EstimatedParameter
        The twin's uncertain parameters, refitted.
    combinations : tuple of Combination
        What the recordings see of the parameters that they cannot see by themselves.
    alignment : mapping of str to Alignment
        How each signal was logged.
    detectable : mapping of str to DetectableSize
        For each effect that is not named, the smallest size that would have shown.
    location : Location
        Where the mismatch sits.
    fit : Fit
        Errors on held-out recordings.
    shape : Shape or None
        The inferred signal where the verdict is `outside_library`.
    next_experiment : NextExperiment or None
        What to record next, where that would tell more.
    not_testable : tuple of NotTestable
        Effects on which nothing can be said, and why.
    cost : Cost
        Simulations and time.
    seed : int
        Seed of all randomness.
    versions : mapping of str to str
        Versions of the software.
    notes : tuple of str
        Plain remarks, such as numerical limits.
    predictions : Predictions or None
        Explanations that remain, with the values that predict a recording under each.
    latent : Shape or None
        What is missing at the torque port, inferred without a name, where physics was named.
    residual_tests : tuple of ResidualTest
        Whether what is left still follows the reference, on held-out recordings.
    curves : tuple of Curve
        Signals before and after, for plots; not part of the JSON.
    augmentation : Augmentation or None
        What the augmented twin is made of; not part of the JSON.
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
    curves: tuple[Curve, ...] = field(default=(), compare=False)
    augmentation: Augmentation | None = field(default=None, compare=False)
    exported: Path | None = field(default=None, compare=False)
    next_reference: str = field(default="", compare=False)

    @property
    def sentence(self) -> str:
        """The verdict in plain words."""
        from gmfbo.diagnosis.sentence import verdict_sentence

        return verdict_sentence(self)

    def to_json(self) -> str:
        """Return the content of `diagnosis.json`; a number that is not finite becomes null."""
        from gmfbo.diagnosis.json_text import diagnosis_text

        return diagnosis_text(self)

    @classmethod
    def from_json(cls, path: str | Path) -> Diagnosis:
        """Read a `diagnosis.json`; an augmented twin beside it can be opened again.

        Parameters
        ----------
        path : str or Path
            The file, or the folder that holds it.

        Returns
        -------
        Diagnosis
            Without curves; null numbers are NaN.

        Raises
        ------
        InputError
            There is no such file, or it is none that gmfbo wrote.
        """
        from gmfbo.diagnosis.json_text import read_diagnosis

        return read_diagnosis(Path(path))

    def save(self, folder: str | Path) -> tuple[Path, ...]:
        """Write `diagnosis.json`, `report.html` and the augmented twin, each whole or not at all.

        Parameters
        ----------
        folder : str or Path
            Made if it is not there; results of an earlier diagnosis in it are replaced.

        Returns
        -------
        tuple of Path
            The files written. Where this twin cannot be exported, a note in them says why.

        Raises
        ------
        InputError
            The folder cannot be written.
        """
        from gmfbo.diagnosis.saving import save

        return save(self, Path(folder))

    def augmented_twin(self, folder: str | Path | None = None) -> FmuTwin:
        """Return the twin with the named physics in it, as an FMU that runs without gmfbo.

        Parameters
        ----------
        folder : str or Path, optional
            Existing folder for its files; without it they are gone once the twin is.

        Returns
        -------
        FmuTwin
            It simulates what this diagnosis reports.

        Raises
        ------
        InputError
            There is no augmented twin, or it cannot be exported.
        """
        if self.augmentation is not None:
            return self.augmentation.opened(None if folder is None else Path(folder))
        if self.exported is not None:
            from gmfbo.sources.twin import FmuTwin

            return FmuTwin(self.exported)
        raise InputError(
            "no augmented twin: expected a diagnosis from this session, or one read from a folder "
            "that holds augmented.toml; run the diagnosis again"
        )

    def __repr__(self) -> str:
        from gmfbo.diagnosis.summary import summary_text

        return summary_text(self)

    def _repr_html_(self) -> str:
        from gmfbo.diagnosis.summary import summary_html

        return summary_html(self)
