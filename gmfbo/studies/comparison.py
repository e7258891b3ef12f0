"""Result of a comparison of methods on the same seeds of one study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from gmfbo.errors import StoreError
from gmfbo.studies.comparison_folder import ComparisonFolder
from gmfbo.studies.curves import read_curves
from gmfbo.studies.landscape import read_landscape
from gmfbo.studies.outcome import Outcome


@dataclass(frozen=True)
class Comparison:
    """Result of a comparison of methods on the same seeds.

    Attributes
    ----------
    folder : Path
        Folder of the comparison.
    text : str
        Its tables.
    outcomes : tuple of Outcome
        All finished runs, also of former calls; empty where only the tables were read.
    failed : mapping of str to str
        `METHOD-SEED` of failed runs of this call, with the reason.
    """

    folder: Path
    text: str = field(repr=False)
    outcomes: tuple[Outcome, ...] = field(default=(), repr=False)
    failed: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def read(cls, folder: str | Path) -> Self:
        """Read the tables of a comparison; its runs may be missing.

        Parameters
        ----------
        folder : str or Path
            Folder written by `compare`.

        Raises
        ------
        StoreError
            There are none.
        """
        kept = ComparisonFolder(Path(folder))
        try:
            return cls(kept.path, kept.table.read_text(encoding="utf-8"))
        except OSError:
            raise StoreError(
                f"{folder}: expected the folder of a comparison, with its table.txt; make it with "
                "'gmfbo compare STUDY.toml --out FOLDER'"
            ) from None

    def draw(self, folder: str | Path) -> list[Path]:
        """Draw the figures from the tables: landscape, sampling cost, best observed.

        Parameters
        ----------
        folder : str or Path
            Folder for the SVG, PDF and PNG files.

        Returns
        -------
        list of Path
            Of the SVG files.

        Raises
        ------
        StoreError
            The tables are not there.
        InputError
            matplotlib is not installed.
        """
        kept = ComparisonFolder(self.folder)
        curves, landscape = read_curves(kept.curves), read_landscape(kept.landscape)
        from gmfbo.reports.figures.comparison_figures import draw_comparison

        return draw_comparison(curves, landscape, Path(folder))

    def __str__(self) -> str:
        return self.text
