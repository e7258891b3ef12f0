"""What a table's roughness alone is worth: the twin is smoothed once, and no recording is used."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gmfbo.retuning.twin_at import TwinAt
from gmfbo.retuning.unknowns import Unknowns
from gmfbo.sources.twin import FmuTwin
from gmfbo.tuning.history import History
from gmfbo.tuning.twin_version import TwinVersion


class SmoothingRefiner:
    """Smooths the tables of a twin before the first query, and then leaves it alone.

    Parameters
    ----------
    twin : FmuTwin
        As the study file names it, with tables.
    """

    def __init__(self, twin: FmuTwin) -> None:
        unknowns = Unknowns.of(twin)
        self._smooth = TwinVersion(
            1, TwinAt(twin, unknowns.settings(unknowns.smoothed)), "its tables were smoothed"
        )
        self._done = False

    def revise(self, history: History) -> TwinVersion | None:
        """Give the smooth twin, once."""
        if self._done:
            return None
        self._done = True
        return self._smooth

    def restore(self, event: Mapping[str, Any]) -> TwinVersion:
        """Give the smooth twin again."""
        self._done = True
        return self._smooth

    def close(self) -> None:
        """Nothing was opened."""
