"""Why simulation and recordings differ: what was found, and what can be done with it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.diagnosis.page.saving import save
from gmfbo.diagnosis.result.cautions import withheld_twin
from gmfbo.diagnosis.result.diagnosis_json import diagnosis_text, read_diagnosis
from gmfbo.diagnosis.result.findings import Findings
from gmfbo.diagnosis.result.sentence import verdict_sentence
from gmfbo.diagnosis.result.summary import summary_html, summary_text
from gmfbo.errors import InputError

if TYPE_CHECKING:
    from gmfbo.sources.twin.twin import FmuTwin


@dataclass(frozen=True, repr=False)
class Diagnosis(Findings):
    """Why simulation and recordings differ: the physics left out, and the fit with it.

    Its fields are those of `gmfbo.diagnosis.result.findings.Findings`.
    """

    @property
    def sentence(self) -> str:
        """The verdict in plain words."""
        return verdict_sentence(self)

    def to_json(self) -> str:
        """Return the content of `diagnosis.json`; a number that is not finite becomes null."""
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
        return read_diagnosis(cls, Path(path))

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
        if self.fit.twin_is_withheld:
            raise InputError(f"no augmented twin: {withheld_twin(self)}")
        if self.exported is not None:
            from gmfbo.sources.twin.twin import FmuTwin

            return FmuTwin(self.exported)
        raise InputError(
            "no augmented twin: expected a diagnosis from this session, or one read from a folder "
            "that holds augmented.toml; run the diagnosis again"
        )

    def __repr__(self) -> str:
        return summary_text(self)

    def _repr_html_(self) -> str:
        return summary_html(self)
