"""A confirmation run: predictions of the explanations against the observation."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from gmfbo.diagnosis.page.saving import CONFIRMATION_FILE
from gmfbo.diagnosis.result.predictions import PARAMETERS_ONLY, said
from gmfbo.errors import InputError
from gmfbo.files.durable import cause, write_whole

FILE_NAME = CONFIRMATION_FILE
SCHEMA = 1

FAR = 4.0
"""Largest error that confirms, over the misfit at the diagnosis [1]."""

MOST_REMOVED = 0.8
"""Share of the parameters-only error that an explanation right in kind removes."""

_CLEAR, _STRONG = 3.0, 10.0  # thresholds by which the next best explanation is farther away

Outcome = Literal["supports", "supports_in_kind", "cannot_tell", "none"]


@dataclass(frozen=True)
class Prediction:
    """Error of one explanation's prediction of a confirmation run.

    Attributes
    ----------
    name : str
        Of the explanation.
    chi2 : float
        Whitened sum of squares of the part that no nuisance was fitted to, and of the nuisances
        in standard deviations of their priors, dimensionless.
    per_residual : float
        chi2 per whitened residual: about one where the prediction is right.
    fitted : float
        chi2 per whitened residual on the recordings that it was fitted to.
    nrmse : mapping of str to float
        By signal: RMS error over the observed range, on the same part and without alignment.
    """

    name: str
    chi2: float
    per_residual: float
    fitted: float
    nrmse: Mapping[str, float]


@dataclass(frozen=True)
class Confirmation:
    """Judgement of a diagnosis' explanations by one later recording.

    Attributes
    ----------
    recording : str
        Name of the observed run.
    scored : tuple of float
        [s] Part of it that was scored.
    predictions : tuple of Prediction
        Nearest first.
    threshold : float
        Difference in chi2 that tells two explanations apart.
    """

    recording: str
    scored: tuple[float, float]
    predictions: tuple[Prediction, ...]
    threshold: float

    @property
    def best(self) -> Prediction:
        """Explanation with the smallest error."""
        return self.predictions[0]

    @property
    def expected(self) -> float:
        """Least chi2 per residual on the recordings of the diagnosis; at least one."""
        return max(1.0, min(p.fitted for p in self.predictions))

    def fits(self, prediction: Prediction) -> bool:
        """Whether an error is less than twice that of the best explanation on its recordings.

        Parameters
        ----------
        prediction : Prediction
            Of one explanation.
        """
        return prediction.per_residual <= FAR * self.expected

    def behind(self, other: Prediction) -> float:
        """Excess chi2 of an explanation over the best, over the best one's chi2 per residual.

        No law is exact, so a difference counts relative to the error of the best prediction.

        Parameters
        ----------
        other : Prediction
            The explanation.
        """
        return (other.chi2 - self.best.chi2) / max(1.0, self.best.per_residual)

    @property
    def alike(self) -> tuple[Prediction, ...]:
        """Explanations that cannot be told from the best one, the best first."""
        return tuple(p for p in self.predictions if self.behind(p) <= self.threshold)

    @property
    def removed(self) -> float:
        """Share of the parameters-only chi2 beyond noise that the best removes; NaN without any."""
        plain = next((p for p in self.predictions if p.name == PARAMETERS_ONLY), None)
        if plain is None or plain is self.best or plain.per_residual <= 1.0:
            return math.nan
        return (plain.per_residual - self.best.per_residual) / (plain.per_residual - 1.0)

    @property
    def outcome(self) -> Outcome:
        """Whether the recording supports one explanation, several, or none."""
        if not self.fits(self.best):
            alone = len(self.alike) == 1 and self.best.name != PARAMETERS_ONLY
            return "supports_in_kind" if alone and self.removed >= MOST_REMOVED else "none"
        return "supports" if len(self.alike) == 1 else "cannot_tell"

    @property
    def strength(self) -> str:
        """Words for the distance of the next best explanation, in thresholds."""
        if len(self.predictions) < 2:
            return ""
        ratio = self.behind(self.predictions[1]) / self.threshold
        return "strongly" if ratio > _STRONG else "clearly" if ratio > _CLEAR else "narrowly"

    @property
    def sentence(self) -> str:
        """The outcome in plain words."""
        best, name = self.best, said(self.best.name)
        left = f"{_times_noise(best.per_residual)} times the noise"
        if self.outcome == "none":
            return (
                f"{self.recording} supports none of them: the nearest, {name}, leaves {left}, "
                f"where {_times_noise(self.expected)} was left of the recordings of the diagnosis. "
                "Diagnose again with this recording among the others."
            )
        if self.outcome == "cannot_tell":
            together = " and ".join(said(p.name) for p in self.alike)
            return f"{self.recording} cannot tell {together} apart: all leave about {left}."
        if len(self.predictions) == 1:
            return f"{self.recording} is as {name} predicted."
        other = self.predictions[1]
        behind = f"{said(other.name)} {_times_noise(other.per_residual)} times"
        if self.outcome == "supports_in_kind":
            return (
                f"{self.recording} supports {name} in kind, not yet in size: it leaves {left}, "
                f"{behind}. Diagnose again with this recording among the others."
            )
        return f"{self.recording} {self.strength} supports {name}: it leaves {left}, {behind}."


def _times_noise(per_residual: float) -> str:
    """Root mean square of what is left, in standard deviations of the noise."""
    return f"{math.sqrt(max(per_residual, 0.0)):.2g}"


def save_confirmation(confirmation: Confirmation, folder: Path) -> Path:
    """Add a confirmation to those of a diagnosis; one of the same recording is replaced.

    Raises
    ------
    InputError
        It cannot be written, or a file of that name is none of ours.
    """
    path = folder / FILE_NAME
    runs = [run for run in _earlier(path) if run.get("recording") != confirmation.recording]
    runs.append(_plain(confirmation))
    content = {"schema": SCHEMA, "runs": runs}
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    try:
        write_whole(path, text.encode("utf-8"))
    except OSError as error:
        raise InputError(f"cannot write '{path}': {cause(error)}") from None
    return path


def _earlier(path: Path) -> list[dict[str, Any]]:
    if not path.exists():
        return []
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["schema"] != SCHEMA:
            raise ValueError("another schema")
        return list(content["runs"])
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(
            f"{path}: expected the confirmations of earlier runs, schema {SCHEMA}; move the file "
            "away"
        ) from None


def _plain(confirmation: Confirmation) -> dict[str, Any]:
    removed = confirmation.removed
    return {
        "recording": confirmation.recording,
        "scored": list(confirmation.scored),
        "outcome": confirmation.outcome,
        "supports": [p.name for p in confirmation.alike] if confirmation.outcome != "none" else [],
        "sentence": confirmation.sentence,
        "threshold": confirmation.threshold,
        "removed": removed if math.isfinite(removed) else None,
        "predictions": [
            {**asdict(p), "behind": confirmation.behind(p)} for p in confirmation.predictions
        ],
    }
